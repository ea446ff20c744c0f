# SPDX-License-Identifier: MIT
"""Checks of geometry that find the kind of a match, with the figures the kind rests on.

Whether one shape is a copy of the other, moved, scaled or mirrored; the same surface with another mesh;
another pose; a part. ``docs/evidence.md`` lists the checks, their tolerances, and how often they are right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shapegoogle_core.library.evidence import Evidence, EvidenceKind
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.settings import EvidenceSettings
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import (
    PART_SCALES,
    SCALES,
    Alignment,
    Fit,
    PreparedSample,
    Surface,
    SurfaceSample,
    TangentPlanes,
    align,
    fit_numbered,
    fit_surface,
    frame_between,
    functional_map,
    mirrored,
    spectral_difference,
)

__all__ = ["Compared", "Explainer", "pose_features"]

# Scales of a part that verification has not tried.
_FURTHER_SCALES = tuple(scale for scale in PART_SCALES if scale not in SCALES)


@dataclass(frozen=True, eq=False)
class Compared:
    """A shape as the checks compare it.

    Attributes
    ----------
    sample : SurfaceSample
    shape : Match, ShapeRecord or ShapeSignature
        With counts and area of the mesh as it was read.
    """

    sample: SurfaceSample
    shape: Match | ShapeRecord | ShapeSignature


class Explainer:
    """Explains matches of one query.

    Parameters
    ----------
    query : Compared
    surface : Mesh, optional
        Preprocessed mesh of the query, at its original place and size. Without it the figures are coarser.
    settings : EvidenceSettings, optional
    """

    def __init__(
        self, query: Compared, surface: Mesh | None = None, settings: EvidenceSettings | None = None
    ) -> None:
        self._settings = settings = EvidenceSettings() if settings is None else settings
        self._query = query
        self._sample = query.sample
        self._surface: Surface | TangentPlanes
        if surface is None:
            self._surface = TangentPlanes(query.sample)
            self._identical = self._remeshed = settings.coarse
            self._near = settings.coarse_near
        else:
            self._surface = Surface(surface, query.sample)
            self._identical, self._remeshed, self._near = settings.identical, settings.remeshed, settings.near

    @cached_property
    def _prepared(self) -> PreparedSample:
        return PreparedSample(self._sample, PART_SCALES)

    @cached_property
    def _prepared_further(self) -> PreparedSample:
        return PreparedSample(self._sample, _FURTHER_SCALES)

    def explain(
        self, match: Compared, similarity: float, distance: float, alignment: Alignment | None = None
    ) -> Evidence:
        """Find the kind of a match.

        Parameters
        ----------
        match : Compared
        similarity : float
            From the search; where it is very low, fewer checks are made.
        distance : float
            Distance of the bags of both.
        alignment : Alignment, optional
            From the query to the match, if verification has found one.

        Returns
        -------
        evidence : Evidence
        """
        sample = match.sample
        same_counts = self._same_counts(match)
        if (copy := self.copy(match)) is not None:
            return copy
        in_place = self._in_place(sample)
        if in_place is not None and self._is_same(in_place, self._remeshed):
            identical = same_counts and self._is_same(in_place, self._identical)
            return self._congruent("identical" if identical else "re-meshed", in_place, sample)
        fitted = self._fitted(sample, similarity, alignment)
        if fitted is not None and self._is_same(fitted, self._remeshed):
            if same_counts and self._is_same(fitted, self._identical):
                return self._congruent(self._moved_or_scaled(fitted, sample), fitted, sample)
            return self._congruent("re-meshed", fitted, sample)
        if similarity >= self._settings.unlikely:
            reflected = self._fitted(mirrored(sample), similarity)
            if reflected is not None and self._is_same(reflected, self._remeshed):
                return self._congruent("mirrored", reflected, sample)
        if fitted is not None and (part := self._part(fitted, match)) is not None:
            return part
        return self._posed(match, distance)

    def copy(self, match: Compared) -> Evidence | None:
        """Recognise a copy whose vertices are in the same order; many times faster than `explain`.

        Parameters
        ----------
        match : Compared

        Returns
        -------
        evidence : Evidence or None
            "identical", "moved", "scaled" or "mirrored"; None for everything else.
        """
        sample = match.sample
        if not self._same_counts(match) or len(sample.points) != len(self._sample.points):
            return None
        moved = fit_numbered(self._sample, sample)
        if moved.deviation <= self._settings.identical:
            kind = "identical" if self._is_in_place(moved, sample) else self._moved_or_scaled(moved, sample)
            return self._congruent(kind, moved, sample)
        reflected = fit_numbered(self._sample, mirrored(sample))
        if reflected.deviation <= self._settings.identical:
            return self._congruent("mirrored", reflected, sample)
        return None

    def _same_counts(self, match: Compared) -> bool:
        query, shape = self._query.shape, match.shape
        return (query.vertex_count, query.face_count) == (shape.vertex_count, shape.face_count)

    def _is_same(self, fitted: Fit, tolerance: float) -> bool:
        return fitted.deviation <= tolerance and fitted.query_covered >= self._settings.whole

    def _is_in_place(self, fitted: Fit, sample: SurfaceSample) -> bool:
        """Whether the points coincide at their original places, and not only after a motion."""
        apart = frame_between(self._sample, sample).apply(sample.points) - fitted.frame.apply(sample.points)
        return float(np.abs(apart).max()) <= self._settings.identical

    def _in_place(self, sample: SurfaceSample) -> Fit | None:
        """Compare both shapes at their original places, unless they are far apart."""
        frame = frame_between(self._sample, sample)
        if max(abs(frame.scale - 1), np.abs(frame.translation).max()) > self._settings.far:
            return None
        return fit_surface(self._surface, self._sample, sample, frame, steps=False)

    def _moved_or_scaled(self, fitted: Fit, sample: SurfaceSample) -> EvidenceKind:
        same_size = abs(self._factor(fitted, sample) - 1) <= self._settings.same_size
        return "moved" if same_size else "scaled"

    def _fitted(
        self, sample: SurfaceSample, similarity: float, alignment: Alignment | None = None
    ) -> Fit | None:
        """Align a sample with the query and fit it, if that is promising."""
        candidate = PreparedSample(sample, PART_SCALES)
        forth = [align(self._prepared, candidate) if alignment is None else alignment]
        if forth[0].agreement < self._settings.sure and similarity >= self._settings.unlikely:
            if alignment is not None:
                forth.append(align(self._prepared_further, candidate))
            # Only a part is tried at other sizes than its whole, so try it the other way round too.
            back = align(candidate, self._prepared)
        else:
            back = None
        best = max(forth, key=lambda found: found.agreement)
        frame, agreement = best.frame.inverse(), best.agreement
        if back is not None and back.agreement > agreement:
            frame, agreement = back.frame, back.agreement
        if agreement < self._settings.promising:
            return None
        return fit_surface(self._surface, self._sample, sample, frame)

    def _factor(self, fitted: Fit, sample: SurfaceSample) -> float:
        """Size of the match relative to the query, both as they were read."""
        return sample.unit / (self._sample.unit * fitted.frame.scale)

    def _congruent(self, kind: EvidenceKind, fitted: Fit, sample: SurfaceSample) -> Evidence:
        factor = self._factor(fitted, sample)
        if abs(factor - 1) <= self._settings.same_size:
            factor = 1.0
        return Evidence(kind, factor=_digits(factor), deviation=_digits(fitted.deviation))

    def _part(self, fitted: Fit, match: Compared) -> Evidence | None:
        """Check whether the smaller surface lies on the larger one."""
        factor = self._factor(fitted, match.sample)
        # Areas of the meshes as they were read: preprocessing has put lids on cuts.
        share = match.shape.area / (self._query.shape.area * factor**2)
        on_query = share < 1
        share = share if on_query else 1 / share
        covered = fitted.covered(self._near) if on_query else fitted.query_covered
        if share > self._settings.largest_part or covered < self._settings.part:
            return None
        near = fitted.distances[fitted.distances <= self._near]
        return Evidence(
            "contains" if on_query else "part of",
            factor=_digits(factor),
            deviation=_digits(float(np.quantile(near, 0.95))) if len(near) else self._near,
            share=_digits(share),
        )

    def _posed(self, match: Compared, distance: float) -> Evidence:
        difference = spectral_difference(self._sample, match.sample)
        factor = _digits(math.sqrt(match.shape.area / self._query.shape.area))
        if difference > self._settings.other_spectrum:
            return Evidence("similar", factor=factor, spectral_difference=_digits(difference))
        found = functional_map(self._sample, match.sample)
        features = pose_features(found.spectral_difference, found.orthogonality, distance)
        odds = float(features @ np.array(self._settings.pose_weights)) + self._settings.pose_offset
        probability = 1 / (1 + math.exp(-max(-50.0, min(50.0, odds))))
        return Evidence(
            "re-posed" if probability >= 0.5 else "similar",
            factor=factor,
            displacement=_digits(found.displacement),
            probability=_digits(probability),
            spectral_difference=_digits(found.spectral_difference),
            residual=_digits(found.orthogonality),
        )


def pose_features(spectral_difference: float, orthogonality: float, distance: float) -> FloatArray:
    """Compute the features of the probability of another pose: logarithms of three figures.

    Parameters
    ----------
    spectral_difference, orthogonality : float
        See `Isometry`.
    distance : float
        Distance of the bags.

    Returns
    -------
    features : (3,) array
    """
    return np.log(np.maximum([spectral_difference, orthogonality, distance], 1e-3))


def _digits(value: float) -> float:
    """Round to four significant digits: more would be noise."""
    return float(f"{value:.4g}")
