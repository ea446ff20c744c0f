# SPDX-License-Identifier: MIT
"""What kind of match a match is, by checks of geometry whose figures are shown.

The search orders by how likely two shapes are the same. Here it is said what they have in common: whether one
is a copy of the other, moved, scaled or mirrored; the same surface of another mesh; another pose; a part.
`docs/evidence.md` lists the checks, their tolerances, and how often they are right.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.evidence import Evidence, EvidenceKind
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.settings import EvidenceSettings
from shapegoogle_core.library.storage.samples import unpack_sample
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import PreparedSample, SurfaceSample, align
from shapegoogle_core.registration.isometry import functional_map, spectral_difference
from shapegoogle_core.registration.prepared_sample import PART_SCALES
from shapegoogle_core.registration.surface_fit import (
    Fit,
    Surface,
    TangentPlanes,
    fit_numbered,
    fit_surface,
    frame_between,
    mirrored,
)

__all__ = ["EXPLAINED", "Compared", "Explainer", "explain_matches", "pose_features"]

EXPLAINED = EvidenceSettings.explained

# Lengths are shares of √area of the query.
EXACT = 1e-3
"""What 95 % of a copy's points may lie off the query's surface: mending rounds no better."""

CLOSE = 5e-3
"""The same for another mesh of the same surface."""

NEAR = 1e-2
"""How near a point lies to a surface that covers it."""

COARSE, COARSE_NEAR = 1.2e-2, 2e-2
"""Instead of these, where only a sample of the query is known: 600 tangent planes tell no more."""

# Share of either surface that must lie on the other one if they are the same.
_WHOLE = 0.97
# Share of the smaller surface that must lie on the larger one if it is a part of it: cuts are mended.
_PART = 0.85
# More of a surface than this is no part of it: something else is the matter.
_LARGEST_PART = 0.95
# Relative difference of sizes that is none.
_SAME_SIZE = 2e-3
# Agreement from which on it pays to look closer, and up to which a better one is looked for.
_PROMISING, _SURE = 0.45, 0.7
# Matches this far down are not worth a second look from the other side, or for a mirror image.
_UNLIKELY = 0.05
# Beyond this difference of the lowest eigenvalues (see `Isometry`) no pose is looked for: poses reach 0.15.
_OTHER_SPECTRUM = 0.35
# Two shapes that far from the same size or place, relative to their own, are not in the same place.
_FAR = 0.1
# Probability that a shape is another pose: logistic regression on generated pairs, made by
# `python -m benchmarks evidence --calibrate`.
_POSE_WEIGHTS = (-2.79, -0.52, -1.26)
_POSE_OFFSET = -9.76


@dataclass(frozen=True, eq=False)
class Compared:
    """What is known of a shape that is compared.

    Attributes
    ----------
    sample : SurfaceSample
    vertex_count, face_count : int
        Of the mesh as it was read.
    area : float
        Of the mesh as it was read, in squared units of its file.
    """

    sample: SurfaceSample
    vertex_count: int
    face_count: int
    area: float


class Explainer:
    """Explains matches of one query.

    Parameters
    ----------
    query : Compared
    surface : Mesh, optional
        The mended mesh that the sample is of, where the query was. Without it the figures are coarser.
    """

    def __init__(self, query: Compared, surface: Mesh | None = None) -> None:
        self._query = query
        self._sample = query.sample
        self._surface: Surface | TangentPlanes
        if surface is None:
            self._surface = TangentPlanes(query.sample)
            self._exact, self._close, self._near = COARSE, COARSE, COARSE_NEAR
        else:
            self._surface = Surface(surface, query.sample)
            self._exact, self._close, self._near = EXACT, CLOSE, NEAR

    @cached_property
    def _prepared(self) -> PreparedSample:
        return PreparedSample(self._sample, PART_SCALES)

    def explain(self, match: Compared, similarity: float, distance: float) -> Evidence:
        """Say what kind of match a shape is.

        Parameters
        ----------
        match : Compared
        similarity : float
            From the search; where it is least, less is tried.
        distance : float
            Between the bags of both.

        Returns
        -------
        evidence : Evidence
        """
        sample = match.sample
        same_counts = self._same_counts(match)
        if (copy := self.copy(match)) is not None:
            return copy
        in_place = self._in_place(sample)
        if in_place is not None and _is_same(in_place, self._close):
            in_place_kind: EvidenceKind = (
                "identical" if same_counts and _is_same(in_place, self._exact) else "re-meshed"
            )
            return self._congruent(in_place_kind, in_place, sample)
        laid = self._laid(sample, similarity)
        if laid is not None and _is_same(laid, self._close):
            kind: EvidenceKind = "re-meshed"
            if same_counts and _is_same(laid, self._exact):
                kind = self._moved_or_scaled("moved", laid, sample)
            return self._congruent(kind, laid, sample)
        if similarity >= _UNLIKELY:
            reflected = self._laid(mirrored(sample), similarity)
            if reflected is not None and _is_same(reflected, self._close):
                return self._congruent("mirrored", reflected, sample)
        if laid is not None and (part := self._part(laid, match)) is not None:
            return part
        return self._posed(match, distance)

    def copy(self, match: Compared) -> Evidence | None:
        """Say of a copy whose vertices are in the same order what it is; many times faster than `explain`.

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
        candidates: tuple[tuple[EvidenceKind, SurfaceSample], ...] = (
            ("moved", sample),
            ("mirrored", mirrored(sample)),
        )
        for kind, candidate in candidates:
            laid = fit_numbered(self._sample, candidate)
            if laid.deviation <= EXACT:
                if kind == "moved" and self._is_in_place(laid, sample):
                    kind = "identical"
                return self._congruent(self._moved_or_scaled(kind, laid, sample), laid, sample)
        return None

    def _same_counts(self, match: Compared) -> bool:
        query = self._query
        return (query.vertex_count, query.face_count) == (match.vertex_count, match.face_count)

    def _is_in_place(self, laid: Fit, sample: SurfaceSample) -> bool:
        """Whether points lie where the files have them, and not only after a motion."""
        apart = frame_between(self._sample, sample).apply(sample.points) - laid.frame.apply(sample.points)
        return float(np.abs(apart).max()) <= EXACT

    def _in_place(self, sample: SurfaceSample) -> Fit | None:
        """Compare both where their files have them, unless they are far apart."""
        frame = frame_between(self._sample, sample)
        if abs(frame.scale - 1) > _FAR or np.abs(frame.translation).max() > _FAR:
            return None
        return fit_surface(self._surface, self._sample, sample, frame, steps=False)

    def _moved_or_scaled(self, kind: EvidenceKind, laid: Fit, sample: SurfaceSample) -> EvidenceKind:
        same_size = abs(self._factor(laid, sample) - 1) <= _SAME_SIZE
        return kind if kind != "moved" or same_size else "scaled"

    def _laid(self, sample: SurfaceSample, similarity: float) -> Fit | None:
        """Lay a sample over the query and fit it, if that promises anything."""
        candidate = PreparedSample(sample, PART_SCALES)
        alignment = align(self._prepared, candidate)
        frame = alignment.frame.inverse()
        agreement = alignment.agreement
        if agreement < _SURE and similarity >= _UNLIKELY:
            # Only a part is tried at other sizes than its whole, so try it the other way round too.
            back = align(candidate, self._prepared)
            if back.agreement > agreement:
                frame, agreement = back.frame, back.agreement
        if agreement < _PROMISING:
            return None
        return fit_surface(self._surface, self._sample, sample, frame)

    def _factor(self, laid: Fit, sample: SurfaceSample) -> float:
        """Size of the match relative to the query's, both as their files have them."""
        return sample.unit / (self._sample.unit * laid.frame.scale)

    def _congruent(self, kind: EvidenceKind, laid: Fit, sample: SurfaceSample) -> Evidence:
        factor = self._factor(laid, sample)
        if abs(factor - 1) <= _SAME_SIZE:
            factor = 1.0
        return Evidence(kind, factor=_digits(factor), deviation=_digits(laid.deviation))

    def _part(self, laid: Fit, match: Compared) -> Evidence | None:
        """Say whether the smaller surface lies on the larger one."""
        factor = self._factor(laid, match.sample)
        # Of the meshes as they were read: mending has put lids on cuts.
        share = match.area / (self._query.area * factor**2)
        on_query = share < 1
        share = share if on_query else 1 / share
        covered = laid.covered(self._near) if on_query else laid.query_covered
        if share > _LARGEST_PART or covered < _PART:
            return None
        near = laid.distances[laid.distances <= self._near]
        return Evidence(
            "contains" if on_query else "part of",
            factor=_digits(factor),
            deviation=_digits(float(np.quantile(near, 0.95))) if len(near) else self._near,
            share=_digits(share),
        )

    def _posed(self, match: Compared, distance: float) -> Evidence:
        difference = spectral_difference(self._sample, match.sample)
        factor = _digits(math.sqrt(match.area / self._query.area))
        if difference > _OTHER_SPECTRUM:
            return Evidence("similar", factor=factor, spectral_difference=_digits(difference))
        found = functional_map(self._sample, match.sample)
        features = pose_features(found.spectral_difference, found.orthogonality, distance)
        odds = float(features @ np.array(_POSE_WEIGHTS)) + _POSE_OFFSET
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
    """Take logarithms of the figures that the probability of another pose is made of.

    Parameters
    ----------
    spectral_difference, orthogonality : float
        See `Isometry`.
    distance : float
        Between the bags.

    Returns
    -------
    features : (3,) array
    """
    return np.log(np.maximum([spectral_difference, orthogonality, distance], 1e-3))


def explain_matches(
    store: Store,
    model: ShapeModel,
    queries: Sequence[ShapeSignature],
    matches: Sequence[Match],
    count: int = EXPLAINED,
) -> list[Match]:
    """Add evidence to the best matches.

    Parameters
    ----------
    store : Store
    model : ShapeModel
    queries : sequence of ShapeSignature
        Examples of what was asked for; each match is compared with the one that is nearest to it by its bags.
        Those without a sample are left out; those without their surface give coarser figures.
    matches : sequence of Match
        Best first.
    count : int, optional
        How many of them.

    Returns
    -------
    matches : list of Match
        All of them, in their order.
    """
    usable = [query for query in queries if query.sample is not None]
    best = matches[:count]
    if not usable or not best:
        return list(matches)
    shape_ids = [match.shape_id for match in best]
    samples = store.samples(shape_ids)
    found, bags = store.bags(shape_ids, model.bag_size)
    distances = np.stack([model.distances(query.bags, bags) for query in usable])
    nearest = dict(zip(found, zip(distances.argmin(axis=0), distances.min(axis=0), strict=True), strict=True))
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        explainers = [
            Explainer(Compared(query.sample, query.vertex_count, query.face_count, query.area), query.surface)
            for query in usable
            if query.sample is not None
        ]
        explained = []
        for match in best:
            data = samples.get(match.shape_id)
            evidence: Evidence | None = None
            if data is not None and match.shape_id in nearest:  # else it was removed meanwhile
                sample = unpack_sample(store, model, match.shape_id, data)
                example, distance = nearest[match.shape_id]
                compared = Compared(sample, match.vertex_count, match.face_count, match.area)
                evidence = explainers[example].explain(compared, match.similarity, float(distance))
            explained.append(replace(match, evidence=evidence))
    return [*explained, *matches[count:]]


def _is_same(laid: Fit, tolerance: float) -> bool:
    return laid.deviation <= tolerance and laid.query_covered >= _WHOLE


def _digits(value: float) -> float:
    """Round to four significant digits: more would be noise."""
    return float(f"{value:.4g}")
