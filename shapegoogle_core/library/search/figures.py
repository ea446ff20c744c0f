# SPDX-License-Identifier: MIT
"""Similarity and evidence of a pair of shapes, which depend on the two and the model only.

A search verifies candidates only where bags are uncertain, and how far it goes depends on the other shapes of
the library. The figures that are reported do not: where the bags of a pair are uncertain, this pair is
verified, whatever else was found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from shapegoogle_core.library.evidence import Evidence
from shapegoogle_core.library.search.kinds import Compared, Explainer
from shapegoogle_core.library.search.query import QuerySample
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.search.verify import lowered_distance
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import Alignment, PartPose, PreparedSample, SurfaceSample, align, measure

__all__ = ["BagFigures", "PairFigures", "with_kind"]

# Least similarity of another triangulation of the same surface, which bags may find less alike.
_SAME_SURFACE = 0.99
# Least probability of "re-posed".
_LIKELY = 0.5
# Agreement in a rough position from which a thorough alignment may find more.
_WORTHWHILE = 0.3
# Largest likeness of shapes that have nothing in common.
_UNLIKE = 0.2


@dataclass(frozen=True)
class BagFigures:
    """Distances of the bags of a query and a match.

    Attributes
    ----------
    distance, typical : float, float or None
        Of this query; see `ShapeModel.typical_distances`.
    pooled, pooled_typical : float, float or None
        Of all examples together, if there are several.
    """

    distance: float
    typical: float | None
    pooled: float
    pooled_typical: float | None


class PairFigures:
    """Compares one query with matches.

    Parameters
    ----------
    model : ShapeModel
        Model that described all shapes.
    settings : SearchSettings
    query : ShapeSignature
    sample : SurfaceSample
        Of the query.
    certain : float
        Similarity by bags from which a pair is not verified.
    """

    def __init__(
        self,
        model: ShapeModel,
        settings: SearchSettings,
        query: ShapeSignature,
        sample: SurfaceSample,
        certain: float,
    ) -> None:
        self._model, self._settings, self._certain = model, settings, certain
        self._sample = QuerySample(sample)
        self._explainer = Explainer(Compared(sample, query, query.measures), query.surface, settings.evidence)

    def poses(self, matches: Sequence[Compared]) -> list[PartPose | None]:
        """Find the poses of many matches at once, which is faster than one by one.

        Parameters
        ----------
        matches : sequence of Compared

        Returns
        -------
        poses : list of PartPose or None
            For `figures`; None for copies of the query, which need none. Independent of each other.
        """
        poses: list[PartPose | None] = [None] * len(matches)
        others = [place for place, match in enumerate(matches) if not self._explainer.is_copy(match)]
        candidates = [PreparedSample(matches[place].sample, (1.0,)) for place in others]
        for place, pose in zip(others, self._explainer.poses(candidates), strict=True):
            poses[place] = pose
        return poses

    def figures(
        self,
        match: Compared,
        bags: BagFigures,
        alignment: Alignment | None = None,
        pose: PartPose | None = None,
    ) -> tuple[float, Evidence]:
        """Find the similarity and the evidence of a match.

        Parameters
        ----------
        match : Compared
        bags : BagFigures
        alignment : Alignment, optional
            From `align`, where the search has found one.
        pose : PartPose, optional
            From `poses`, where it is known.

        Returns
        -------
        similarity : float
        evidence : Evidence
        """
        by_bags = float(self._model.similarity(bags.pooled, bags.pooled_typical))
        if (copy := self._explainer.copy(match)) is not None:
            return 1.0, copy
        if (other := self._explainer.other_mesh(match)) is not None:
            return max(by_bags, _SAME_SURFACE), other
        weighed = float(self._model.weighed_distances(bags.distance, bags.typical))
        candidate = PreparedSample(match.sample, (1.0,))
        if pose is None:
            (pose,) = self._explainer.poses([candidate])
        if by_bags >= self._certain:
            return by_bags, _limited(self._explainer.relate(match, weighed, pose), by_bags, bags, weighed)
        verified, pose = self._verify(candidate, bags, pose, alignment)
        similarity = float(self._model.similarity(verified, bags.pooled_typical, verified=True))
        evidence = self._explainer.relate(match, weighed, pose)
        return similarity, _limited(evidence, similarity, bags, weighed)

    def _verify(
        self, candidate: PreparedSample, bags: BagFigures, pose: PartPose, alignment: Alignment | None
    ) -> tuple[float, PartPose]:
        """Lower the distance of the bags as a search does; align thoroughly only where it is worthwhile.

        Whether it is depends on the pair, and not on what the search has aligned. Returns the distance, and
        the better pose if the alignment has found one.
        """
        if not pose.is_promising or pose.frame is None:
            return bags.pooled, pose
        query = self._sample.prepared
        found = measure(query, candidate, pose.frame.inverse())
        verified = self._lowered(bags, found, pose)
        similarity = float(self._model.similarity(verified, bags.pooled_typical, verified=True))
        is_certain = similarity >= self._settings.verification.likely
        if is_certain or (pose.of_query and found.agreement < _WORTHWHILE):
            return verified, pose
        alignment = align(query, candidate) if alignment is None else alignment
        pose = self._explainer.refined(candidate, pose, alignment)
        return min(verified, self._lowered(bags, alignment, pose)), pose

    def _lowered(self, bags: BagFigures, alignment: Alignment, pose: PartPose) -> float:
        exact = pose.exact if pose.of_query else 0.0
        return lowered_distance(self._model, self._settings.verification, bags.pooled, alignment, exact)


def _limited(evidence: Evidence, similarity: float, bags: BagFigures, weighed: float) -> Evidence:
    """Call a plain shape another pose only as far as it is the same shape.

    Eigenfunctions of two lumps agree as those of two poses do.
    """
    if evidence.probability is None or weighed <= bags.distance or evidence.probability <= similarity:
        return evidence
    kind = evidence.kind if evidence.kind != "re-posed" or similarity >= _LIKELY else "similar"
    return replace(evidence, kind=kind, probability=float(f"{similarity:.4g}"))


def with_kind(evidence: Evidence, similarity: float, likeness: float | None) -> Evidence:
    """Say of two different surfaces whether they are of one kind, where that can be told.

    Parameters
    ----------
    evidence : Evidence
    similarity : float
    likeness : float or None

    Returns
    -------
    evidence : Evidence
        "similar" is "same kind" or "nothing in common" if the likeness is clear; two shapes that are probably
        the same stay "similar".
    """
    if evidence.kind != "similar" or likeness is None or similarity >= _LIKELY:
        return evidence
    if likeness >= _LIKELY:
        return replace(evidence, kind="same kind")
    return replace(evidence, kind="nothing in common") if likeness <= _UNLIKE else evidence
