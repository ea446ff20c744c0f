# SPDX-License-Identifier: MIT
"""Checks of geometry that find the kind of a match, with the figures the kind rests on.

Whether one shape is a copy of the other, moved, scaled or mirrored; the same surface with another mesh;
another pose; a part. ``docs/concepts/evidence.md`` lists the checks, their tolerances, and how often they are
right.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shapegoogle_core.library.evidence import Evidence, EvidenceKind
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.evidence.copies import copy_kind
from shapegoogle_core.library.search.settings import EvidenceSettings
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import (
    Alignment,
    Fit,
    Frame,
    IsometryTest,
    MeshMeasures,
    PartPose,
    PartPoses,
    PreparedSample,
    Surface,
    SurfaceSample,
    TangentPlanes,
    align,
    are_flat_sided,
    best_frame,
    fit_numbered,
    fit_surface,
    frame_between,
    handed_alike,
    is_same_size,
    may_be_bent,
    mirrored,
    principal_motions,
    shared_modes,
    spectral_difference,
    surface_difference,
)

__all__ = ["Compared", "Explainer", "pose_features"]


@dataclass(frozen=True, eq=False)
class Compared:
    """A shape as the checks compare it.

    Attributes
    ----------
    sample : SurfaceSample
    shape : Match, ShapeRecord or ShapeSignature
        With the area of the mesh as it was read.
    measures : MeshMeasures or None
        Of the mesh as it was read. Without them no surface is called the same.
    """

    sample: SurfaceSample
    shape: Match | ShapeRecord | ShapeSignature
    measures: MeshMeasures | None


class Explainer:
    """Explains matches of one query.

    Parameters
    ----------
    query : Compared
    surface : Mesh, optional
        Preprocessed mesh of the query, at its original place and size. Without it the figures are coarser.
    settings : EvidenceSettings, optional
    prepared : PreparedSample, optional
        Of the query, where it is used for other comparisons too.
    """

    def __init__(
        self,
        query: Compared,
        surface: Mesh | None = None,
        settings: EvidenceSettings | None = None,
        prepared: PreparedSample | None = None,
    ) -> None:
        self._settings = settings = EvidenceSettings() if settings is None else settings
        self._query = query
        self._sample = query.sample
        self._prepared = PreparedSample(query.sample) if prepared is None else prepared
        self._surface: Surface | TangentPlanes
        if surface is None:
            self._surface = TangentPlanes(query.sample)
            self._remeshed, self._near = settings.coarse, settings.coarse_near
        else:
            self._surface = Surface(surface, query.sample)
            self._remeshed, self._near = settings.remeshed, settings.near

    @cached_property
    def _parts(self) -> PartPoses:
        return PartPoses(self._prepared)

    @cached_property
    def _isometries(self) -> IsometryTest:
        return IsometryTest(self._sample)

    def explain(self, match: Compared, distance: float) -> Evidence:
        """Find the kind of a match.

        Parameters
        ----------
        match : Compared
        distance : float
            Distance of the bags of both, see `ShapeModel.weighed_distances`.

        Returns
        -------
        evidence : Evidence
        """
        if (found := self.copy(match) or self.other_mesh(match)) is not None:
            return found
        (pose,) = self.poses([PreparedSample(match.sample, (1.0,))])
        return self.relate(match, distance, pose)

    def poses(self, candidates: Sequence[PreparedSample]) -> list[PartPose]:
        """Find how matches lie on the query, or the query on them; many at once are faster than one by one.

        Parameters
        ----------
        candidates : sequence of PreparedSample
            Of the matches.

        Returns
        -------
        poses : list of PartPose
        """
        return self._parts.find(candidates)

    def refined(self, candidate: PreparedSample, pose: PartPose, alignment: Alignment) -> PartPose:
        """Try the position that verification has found too; see `PartPoses.refine`.

        Parameters
        ----------
        candidate : PreparedSample
        pose : PartPose
        alignment : Alignment
            From the query to the match.

        Returns
        -------
        pose : PartPose
        """
        return self._parts.refine(candidate, pose, alignment)

    def relate(self, match: Compared, distance: float, pose: PartPose) -> Evidence:
        """Find the kind of a match that is another surface: a part, another pose, or none of these.

        Parameters
        ----------
        match : Compared
        distance : float
            As for `explain`.
        pose : PartPose
            From `poses`.

        Returns
        -------
        evidence : Evidence
        """
        is_exact = pose.exact >= self._settings.promising
        may_be_version = pose.covered >= self._settings.widely and not self._are_flat_sided(match)
        if pose.frame is not None and (is_exact or may_be_version):
            fitted = fit_surface(self._surface, self._sample, match.sample, pose.frame)
            if (version := self._version(fitted, match)) is not None:
                return version
            # A part is no smoothed surface: it fits exactly, or not at all.
            if is_exact and (part := self._part(fitted, match)) is not None:
                return part
        return self._posed(match, distance)

    def is_copy(self, match: Compared) -> bool:
        """Decide whether a match is a copy of the query's mesh, of which nothing else needs to be found.

        Parameters
        ----------
        match : Compared

        Returns
        -------
        copy : bool
        """
        return copy_kind(self._query.measures, match.measures) is not None

    def copy(self, match: Compared) -> Evidence | None:
        """Recognise a copy of the query's mesh by its measures; many times faster than `explain`.

        Parameters
        ----------
        match : Compared

        Returns
        -------
        evidence : Evidence or None
            "identical", "moved", "scaled" or "mirrored"; None for everything else.
        """
        own, other = self._query.measures, match.measures
        found = copy_kind(own, other)
        if found is None or own is None or other is None:
            return None
        kind, factor = found
        if kind == "identical":
            exact = own.hash == other.hash
            frame = frame_between(self._sample, match.sample)
            fitted = (
                None if exact else fit_surface(self._surface, self._sample, match.sample, frame, steps=False)
            )
            return Evidence(kind, deviation=0.0 if fitted is None else _digits(fitted.deviation))
        reflected = kind == "mirrored"
        sample = mirrored(match.sample) if reflected else match.sample
        fits = [fit_numbered(self._sample, sample)] if len(sample.points) == len(self._sample.points) else []
        if not (fits and fits[0].deviation <= self._settings.identical):
            fits += self._placed(match, own, other, reflected=reflected)
        # The measures are certain, the fit is not: a sample on its own may be too coarse for thin walls.
        deviation = min(fitted.deviation for fitted in fits)
        return Evidence(
            kind,
            factor=_digits(factor),
            deviation=_digits(deviation) if deviation <= self._remeshed else None,
        )

    def _placed(
        self, match: Compared, own: MeshMeasures, other: MeshMeasures, *, reflected: bool
    ) -> list[Fit]:
        """Fit a surface with the same moments as the query's, in the positions in which the axes coincide."""
        sample = mirrored(match.sample) if reflected else match.sample
        flip = np.diag([-1.0, 1.0, 1.0]) if reflected else np.eye(3)
        frames = []
        for scale, turn, shift in principal_motions(own, other, reflected=reflected):
            center = (scale * turn @ match.sample.center + shift - self._sample.center) / self._sample.unit
            size = scale * match.sample.unit / self._sample.unit
            frames.append(Frame(size, turn @ flip, center))
        if frames:
            frame = best_frame(self._surface, sample, frames)
            return [fit_surface(self._surface, self._sample, sample, frame)]
        alone = self._prepared.at_other_scales((1.0,))
        frame = align(alone, PreparedSample(sample)).frame.inverse()
        return [fit_surface(self._surface, self._sample, sample, frame)]

    def other_mesh(self, match: Compared) -> Evidence | None:
        """Recognise the same surface with other triangles, by its moments and by a fit.

        Parameters
        ----------
        match : Compared

        Returns
        -------
        evidence : Evidence or None
            "re-meshed" or "mirrored"; None for everything else.
        """
        own, other = self._query.measures, match.measures
        if own is None or other is None:
            return None
        difference, tolerance = surface_difference(own, other)
        if not difference <= tolerance:
            return None
        alike, is_flat = handed_alike(own, other), tolerance <= self._settings.flat
        # Of a curved surface that is almost its own mirror image only the fit can tell.
        for reflected in (False, True) if alike is None and not is_flat else (alike is False,):
            found = self._placed(match, own, other, reflected=reflected)
            best = min(found, key=lambda fitted: fitted.deviation)
            if best.deviation <= self._remeshed and best.query_covered >= self._settings.whole:
                return self._congruent("mirrored" if reflected else "re-meshed", best, match)
        if not is_flat:
            return None
        # Of flat-sided shapes the moments are exact, and more certain than the fit of a sample.
        factor = 1.0 if is_same_size(own, other) else other.unit / own.unit
        return Evidence("mirrored" if alike is False else "re-meshed", factor=_digits(factor))

    def _factor(self, fitted: Fit, sample: SurfaceSample) -> float:
        """Size of the match relative to the query, both as they were read."""
        return sample.unit / (self._sample.unit * fitted.frame.scale)

    def _congruent(self, kind: EvidenceKind, fitted: Fit, match: Compared) -> Evidence:
        factor = self._factor(fitted, match.sample)
        if abs(factor - 1) <= self._settings.same_size:
            factor = 1.0
        return Evidence(kind, factor=_digits(factor), deviation=_digits(fitted.deviation))

    def _version(self, fitted: Fit, match: Compared) -> Evidence | None:
        """Check whether each surface lies on all of the other one, but for small changes.

        Of two flat-sided parts such a change is another size, and not a smoother or a coarser mesh.
        """
        settings = self._settings
        # The cheap test first: distances from faces are measured only where they decide.
        if (
            self._are_flat_sided(match)
            or fitted.query_covered < settings.whole
            or fitted.covered(settings.version) < settings.whole
        ):
            return None
        return self._congruent("version", fitted, match)

    def _are_flat_sided(self, match: Compared) -> bool:
        own, other = self._query.measures, match.measures
        return own is not None and other is not None and are_flat_sided(own, other)

    def _part(self, fitted: Fit, match: Compared) -> Evidence | None:
        """Check whether the smaller surface lies on the larger one."""
        factor = self._factor(fitted, match.sample)
        # Areas of the meshes as they were read: preprocessing has put lids on cuts.
        share = match.shape.area / (self._query.shape.area * factor**2)
        on_query = share < 1
        share = share if on_query else 1 / share
        if share > self._settings.largest_part:
            return None
        # A smoothed surface is smaller, too, but nothing is far from it.
        far, least = self._settings.far, self._settings.missing * (1 - share)
        # Of either pair of conditions the one first that needs no distances from faces.
        if on_query:
            is_part = (
                1 - fitted.query_within(far) >= least and fitted.covered(self._near) >= self._settings.part
            )
        else:
            is_part = fitted.query_covered >= self._settings.part and 1 - fitted.covered(far) >= least
        if not is_part:
            return None
        near = fitted.distances[fitted.distances <= self._near]
        return Evidence(
            "contains" if on_query else "part of",
            factor=_digits(factor),
            deviation=_digits(float(np.quantile(near, 0.95))) if len(near) else self._near,
            share=_digits(share),
        )

    def _posed(self, match: Compared, distance: float) -> Evidence:
        own, other = self._query.measures, match.measures
        difference = spectral_difference(self._sample, match.sample)
        factor = _digits(math.sqrt(match.shape.area / self._query.shape.area))
        is_rigid = own is not None and other is not None and not may_be_bent(own, other)
        is_known = shared_modes(self._sample, match.sample) >= self._settings.fewest_modes
        if is_rigid or not is_known or difference > self._settings.other_spectrum:
            return Evidence("similar", factor=factor, spectral_difference=_digits(difference))
        if self._pose_probability(difference, self._settings.least_residual, distance) < 0.5:
            return Evidence("similar", factor=factor, spectral_difference=_digits(difference))
        found = self._isometries.functional_map(match.sample)
        probability = self._pose_probability(found.spectral_difference, found.orthogonality, distance)
        return Evidence(
            "re-posed" if probability >= 0.5 else "similar",
            factor=factor,
            displacement=_digits(found.displacement),
            probability=_digits(probability),
            spectral_difference=_digits(found.spectral_difference),
            residual=_digits(found.orthogonality),
        )

    def _pose_probability(self, spectral_difference: float, orthogonality: float, distance: float) -> float:
        features = pose_features(spectral_difference, orthogonality, distance)
        odds = float(features @ np.array(self._settings.pose_weights)) + self._settings.pose_offset
        return 1 / (1 + math.exp(-max(-50.0, min(50.0, odds))))


def pose_features(spectral_difference: float, orthogonality: float, distance: float) -> FloatArray:
    """Compute the features of the probability of another pose: logarithms of three figures.

    Parameters
    ----------
    spectral_difference, orthogonality : float
        See `Isometry`.
    distance : float
        Distance of the bags, see `ShapeModel.weighed_distances`.

    Returns
    -------
    features : (3,) array
    """
    return np.log(np.maximum([spectral_difference, orthogonality, distance], 1e-3))


def _digits(value: float) -> float:
    """Round to four significant digits: more would be noise."""
    return float(f"{value:.4g}")
