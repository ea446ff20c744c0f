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
from shapegoogle_core.library.search.evidence.kinds import Compared
from shapegoogle_core.library.search.prepared import PreparedQuery
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.search.verified_distances import (
    bent_distance,
    covers_whole,
    lowered_distance,
)
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import (
    Alignment,
    Frame,
    PartPose,
    PreparedSample,
    SurfaceSample,
    align_all,
    measure,
)

__all__ = ["BagFigures", "PairFigures", "Position", "with_kind"]

# Least similarity of another triangulation of the same surface, which bags may find less alike.
_SAME_SURFACE = 0.99
# Least probability of "re-posed".
_LIKELY = 0.5
# Agreement in a rough position from which a thorough alignment may find more.
_WORTHWHILE = 0.3
# Largest likeness and similarity of shapes that have nothing in common.
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


@dataclass(frozen=True, eq=False)
class Position:
    """How a match and a query lie on each other, as far as it was sought.

    Attributes
    ----------
    candidate : PreparedSample
        Of the match.
    pose : PartPose
    rough : Alignment or None
        Agreement in this pose, if the bags are uncertain and it is promising.
    thorough : Alignment or None
        From the query to the match, if a thorough alignment was worthwhile and found something.
    """

    candidate: PreparedSample
    pose: PartPose
    rough: Alignment | None = None
    thorough: Alignment | None = None

    def turned(self, sample: SurfaceSample, rotation: FloatArray) -> Position:
        """Carry it along with a match that is turned.

        Parameters
        ----------
        sample : SurfaceSample
            Of the match that was turned.
        rotation : (3, 3) array

        Returns
        -------
        position : Position
        """
        pose, frame = self.pose, self.pose.frame
        if frame is not None:
            pose = replace(pose, frame=Frame(frame.scale, frame.rotation @ rotation.T, frame.translation))
        return Position(
            PreparedSample(sample, (1.0,)),
            pose,
            _turned(self.rough, rotation),
            _turned(self.thorough, rotation),
        )


def _turned(alignment: Alignment | None, rotation: FloatArray) -> Alignment | None:
    if alignment is None:
        return None
    frame = alignment.frame
    moved = Frame(frame.scale, rotation @ frame.rotation, rotation @ frame.translation)
    return replace(alignment, frame=moved)


class PairFigures:
    """Compares one query with matches.

    Parameters
    ----------
    model : ShapeModel
        Model that described all shapes.
    settings : SearchSettings
    query : PreparedQuery
    certain : float
        Similarity by bags from which a pair is not verified.
    """

    def __init__(
        self,
        model: ShapeModel,
        settings: SearchSettings,
        query: PreparedQuery,
        certain: float,
    ) -> None:
        self._model, self._settings, self._certain = model, settings, certain
        self._prepared, self._explainer = query.prepared, query.explainer

    def positions(
        self,
        matches: Sequence[Compared],
        bags: Sequence[BagFigures],
        alignments: Sequence[Alignment | None],
    ) -> list[Position | None]:
        """Find how many matches and the query lie on each other, which is faster than one by one.

        Parameters
        ----------
        matches : sequence of Compared
        bags : sequence of BagFigures
        alignments : sequence of Alignment or None
            From `align`, where the search has found one.

        Returns
        -------
        positions : list of Position or None
            For `figures`; None for copies of the query, which need none. Independent of each other.
        """
        others = [place for place, match in enumerate(matches) if not self._explainer.is_copy(match)]
        candidates = [PreparedSample(matches[place].sample, (1.0,)) for place in others]
        found: dict[int, Position] = {}
        wanted = []
        for place, candidate, pose in zip(others, candidates, self._explainer.poses(candidates), strict=True):
            rough = self._rough(candidate, bags[place], pose)
            found[place] = Position(candidate, pose, rough)
            # Whether a pair is aligned depends on the pair, and not on what the search has aligned.
            if rough is not None and self._is_worthwhile(bags[place], pose, rough):
                known = alignments[place]
                found[place] = replace(found[place], thorough=known)
                if known is None:
                    wanted.append(place)
        samples = [matches[place].sample for place in wanted]
        for place, alignment in zip(wanted, align_all(self._prepared, samples), strict=True):
            found[place] = replace(found[place], thorough=alignment)
        return [found.get(place) for place in range(len(matches))]

    def _rough(self, candidate: PreparedSample, bags: BagFigures, pose: PartPose) -> Alignment | None:
        """Measure the agreement in a pose, where bags are uncertain."""
        if self._by_bags(bags) >= self._certain or not pose.is_promising or pose.frame is None:
            return None
        return measure(self._prepared, candidate, pose.frame.inverse())

    def _is_worthwhile(self, bags: BagFigures, pose: PartPose, rough: Alignment) -> bool:
        """Decide whether a thorough alignment may find more."""
        verified = self._lowered(bags, rough, pose)
        similarity = float(self._model.similarity(verified, bags.pooled_typical, verified=True))
        if similarity >= self._settings.verification.likely:
            return False
        return not pose.of_query or rough.agreement >= _WORTHWHILE

    def figures(
        self, match: Compared, bags: BagFigures, position: Position | None = None
    ) -> tuple[float, Evidence]:
        """Find the similarity and the evidence of a match.

        Parameters
        ----------
        match : Compared
        bags : BagFigures
        position : Position, optional
            From `positions`, where it is known.

        Returns
        -------
        similarity : float
        evidence : Evidence
        """
        by_bags = self._by_bags(bags)
        if (copy := self._explainer.copy(match)) is not None:
            return 1.0, copy
        if (other := self._explainer.other_mesh(match)) is not None:
            return max(by_bags, _SAME_SURFACE), other
        if position is None:
            (position,) = self.positions([match], [bags], [None])
            assert position is not None  # it is no copy
        weighed = float(self._model.weighed_distances(bags.distance, bags.typical))
        if by_bags >= self._certain:
            evidence = self._explainer.relate(match, weighed, position.pose)
            return by_bags, _limited(evidence, by_bags, bags, weighed)
        verified, pose = self._verify(bags, position)
        alignment = position.rough if position.thorough is None else position.thorough
        if alignment is None or not covers_whole(self._settings.verification, alignment):
            verified = self._if_bent(match.sample, bags, verified, pose)
        similarity = float(self._model.similarity(verified, bags.pooled_typical, verified=True))
        evidence = self._explainer.relate(match, weighed, pose)
        return similarity, _limited(evidence, similarity, bags, weighed)

    def _by_bags(self, bags: BagFigures) -> float:
        return float(self._model.similarity(bags.pooled, bags.pooled_typical))

    def _verify(self, bags: BagFigures, position: Position) -> tuple[float, PartPose]:
        """Lower the distance of the bags as a search does; return the better pose too, if one was found."""
        pose, rough, thorough = position.pose, position.rough, position.thorough
        if rough is None:
            return bags.pooled, pose
        verified = self._lowered(bags, rough, pose)
        if thorough is None:
            return verified, pose
        pose = self._explainer.refined(position.candidate, pose, thorough)
        return min(verified, self._lowered(bags, thorough, pose)), pose

    def _if_bent(self, sample: SurfaceSample, bags: BagFigures, verified: float, pose: PartPose) -> float:
        """Change the distance by whether the query may be a part of the match in another pose."""
        bent, heat = self._prepared.bent, sample.local_heat
        if bent is None or heat is None:
            return verified
        settings, exact = self._settings.verification, pose.exact if pose.of_query else 0.0
        return bent_distance(self._model, settings, verified, bags.pooled, exact, bent.difference(heat))

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
        the same stay "similar", and so do those that may well be the same, and are not alike.
    """
    if evidence.kind != "similar" or likeness is None or similarity >= _LIKELY:
        return evidence
    if likeness >= _LIKELY:
        return replace(evidence, kind="same kind")
    return replace(evidence, kind="nothing in common") if max(likeness, similarity) <= _UNLIKE else evidence
