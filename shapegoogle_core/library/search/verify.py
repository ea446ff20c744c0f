# SPDX-License-Identifier: MIT
"""Third stage of a search: geometric verification, the alignment of the best candidates with the query.

Bags know which words a shape has and which of them lie close together. A part cut off or a swollen limb
changes them as much as another shape would; in space the rest still fits exactly. How exactly it fits tells
the whole of a part from its relatives, which have much in common with the part too.

Verification is used only where bags are not certain. They know more about a shape in another pose: geometry
finds another individual in the query's own pose.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.match import Match, typical_distances
from shapegoogle_core.library.search.query import QuerySample, QuerySamples
from shapegoogle_core.library.search.settings import VerificationSettings
from shapegoogle_core.library.search.surfaces import (
    Surfaces,
    candidate_supports,
    prepared_candidates,
    remembered,
)
from shapegoogle_core.library.search.verified_distances import (
    bent_distance,
    covers_whole,
    lowered_distance,
)
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import (
    SHARED_SCALES,
    Alignment,
    PreparedSample,
    RoughPose,
    SurfaceSample,
    align,
    align_all,
    fit_exactly,
    measure,
    rough_poses,
)

__all__ = ["Sharing", "Verifier", "known_alignment", "verify_pair"]

# An alignment that has found something lowers the distance of the bags to less than this share of it.
_FOUND = 0.8


@dataclass(frozen=True)
class Sharing:
    """Shapes that may share parts with the query.

    Attributes
    ----------
    scales : mapping of int to collection of int
        By shape id, the most promising first: positions of the `SHARED_SCALES` of the query to try. Some of
        them may be among the best by their bags.
    relatives : sequence of Match
        Those that are not among the best by their bags.
    """

    scales: Mapping[int, Collection[int]]
    relatives: Sequence[Match]


@dataclass(eq=False)
class _Pair:
    """A match aligned with the query, as far as its surface is known, and the share that fits exactly."""

    match: Match
    prepared: PreparedSample | None
    alignment: Alignment | None
    exact: float = 0.0
    is_full: bool = True  # from `align`, which does not depend on other shapes


class Verifier:
    """Aligns candidates with the query.

    Parameters
    ----------
    surfaces : Surfaces
        Samples of the candidates.
    model : ShapeModel
        Model that described the shapes.
    settings : VerificationSettings
    """

    def __init__(self, surfaces: Surfaces, model: ShapeModel, settings: VerificationSettings) -> None:
        self._surfaces = surfaces
        self._model = model
        self._settings = settings

    def is_needed(self, best: Match, *, several: bool, cut: bool) -> bool:
        """Decide whether bags are uncertain.

        Parameters
        ----------
        best : Match
            The best match by its bags; with several examples, the best that is no copy of one of them.
        several : bool
            Whether the query has several examples.
        cut : bool
            Whether it is cut off somewhere.

        Returns
        -------
        needed : bool
        """
        return best.similarity < self._settings.enough(several=several, cut=cut)

    def verify(
        self, samples: QuerySamples, matches: Sequence[Match], find_sharing: Callable[[], Sharing]
    ) -> list[Match]:
        """Align the best matches with the query, and lower the distances of those that fit.

        Parameters
        ----------
        samples : QuerySamples
        matches : sequence of Match
            The best by their bags, best first; at least one.
        find_sharing : callable
            Finds shapes that may share parts with the query. Called only if none of the first matches is
            likely.

        Returns
        -------
        matches : list of Match
            All of both, best first.
        """
        settings = self._settings
        # Where geometry has found nothing, the same bags are a weaker sign than without verification.
        matches = self._doubted(matches)
        samples.choose(matches)
        # On matrices of this size a second BLAS thread only doubles the processor time.
        with threadpool_limits(1, user_api="blas"):
            pairs = self._aligned(samples, matches[: settings.first])
            rest = list(matches[settings.first :])
            if max(self._verified(samples, pair).similarity for pair in pairs.values()) < settings.likely:
                sharing = find_sharing()
                relatives = self._doubted(sharing.relatives)
                samples.choose(relatives)
                rest += relatives
                near = matches[settings.first : settings.candidates]
                pairs |= self._fitted(samples, [*near, *relatives], sharing)
                # A shape that the query fits exactly would come before all that are aligned now.
                if max(pair.exact for pair in pairs.values()) < settings.surely_exact:
                    chosen = self._promising(samples, near)[: settings.next]
                    # The bags of shapes that only words propose are far away: they would not be among the
                    # others.
                    chosen += self._promising(samples, relatives)[: settings.next_relatives]
                    for shape_id, pair in self._aligned(samples, chosen, settings.finely).items():
                        known = pairs.get(shape_id)
                        if known is None or self._distance(pair) <= self._distance(known):
                            pairs[shape_id] = pair
            verified = [self._verified(samples, pair) for pair in pairs.values()]
            found = [*verified, *(match for match in rest if match.shape_id not in pairs)]
            if self._may_be_bent(found, pairs):
                found = self._with_bent(samples, found, pairs)
        return sorted(found, key=lambda match: match.rank_key)

    def _doubted(self, matches: Sequence[Match]) -> list[Match]:
        distances = np.array([match.distance for match in matches])
        similarities = self._model.similarity(distances, typical_distances(matches), verified=True)
        return [
            replace(match, similarity=float(similarity))
            for match, similarity in zip(matches, similarities, strict=True)
        ]

    def _aligned(
        self, samples: QuerySamples, matches: Sequence[Match], finely: int | None = None
    ) -> dict[int, _Pair]:
        """Align matches, or those that agree most of them; fit those exactly that cover most of the query."""
        pairs: dict[int, _Pair] = {}
        surfaces = remembered(self._surfaces, samples.surfaces)
        candidates = list(prepared_candidates(surfaces, matches))
        for example in samples.examples:
            own = [pair for pair in candidates if samples.of(pair[0]) is example]
            pairs |= {match.shape_id: _Pair(match, None, None) for match, _ in own}
            known = [(match, prepared) for match, prepared in own if prepared is not None]
            among = [prepared.sample for _, prepared in known]
            for (match, prepared), alignment in zip(
                known, align_all(example.prepared, among, finely=finely), strict=True
            ):
                pairs[match.shape_id] = _Pair(match, prepared, alignment)
        self._fit_covering(samples, pairs.values())
        return pairs

    def _fit_covering(self, samples: QuerySamples, pairs: Iterable[_Pair]) -> None:
        covering = [
            (float(pair.alignment.query_covered.mean()), pair) for pair in pairs if pair.alignment is not None
        ]
        covering.sort(key=lambda scored: (-scored[0], scored[1].match.rank_key))
        for _, pair in covering[: self._settings.exact_fits_of_aligned]:
            if pair.prepared is not None and pair.alignment is not None:
                query = samples.of(pair.match).prepared
                pair.exact, _ = fit_exactly(
                    query, pair.prepared, pair.alignment.frame, hopeless=self._settings.exact_from
                )

    def _promising(self, samples: QuerySamples, matches: Sequence[Match]) -> list[Match]:
        """Order matches by their bags and their support in space."""
        promises = []
        surfaces = remembered(self._surfaces, samples.surfaces)
        scales = range(len(SHARED_SCALES))
        for example in samples.examples:
            own = [match for match in matches if samples.of(match) is example]
            asked = {match.shape_id: scales for match in own if match.shape_id not in example.supports}
            example.supports |= candidate_supports(
                surfaces, example.shared, asked, finely=2 * self._settings.next
            )
            for match in own:
                known = example.supports.get(match.shape_id)
                support = 0.0 if known is None else float(known.max())
                promise = match.distance * math.exp(-self._settings.support_gain * support)
                promises.append((promise, match))
        promises.sort(key=lambda pair: (pair[0], pair[1].rank_key))
        return [match for _, match in promises]

    def _fitted(self, samples: QuerySamples, matches: Sequence[Match], sharing: Sharing) -> dict[int, _Pair]:
        """Align the query roughly with matches that may share parts with it; fit it exactly to the best."""
        poses: list[tuple[Match, RoughPose]] = []
        surfaces = remembered(self._surfaces, samples.surfaces)
        for example in samples.examples:
            own = {match.shape_id: match for match in matches if samples.of(match) is example}
            sharers = [own[shape_id] for shape_id in sharing.scales if shape_id in own]
            sharers = sharers[: self._settings.rough_fits]
            known = dict(surfaces([match.shape_id for match in sharers]))
            sharers = [match for match in sharers if match.shape_id in known]
            tried = [sharing.scales[match.shape_id] for match in sharers]
            among = [known[match.shape_id] for match in sharers]
            poses += zip(sharers, rough_poses(example.shared, among, tried), strict=True)
        best = sorted(poses, key=lambda pose: (-pose[1].covered, pose[0].rank_key))
        best = best[: self._settings.exact_fits]
        pairs = {}
        candidates = prepared_candidates(surfaces, [match for match, _ in best])
        for (match, prepared), (_, pose) in zip(candidates, best, strict=True):
            frame = pose.frame
            if prepared is not None and frame is not None:
                query = samples.of(match).shared
                exact, frame = fit_exactly(query, prepared, frame, hopeless=self._settings.exact_from)
                if exact < self._settings.exact_from:
                    continue
                alignment = measure(query, prepared, frame)
                pairs[match.shape_id] = _Pair(match, prepared, alignment, exact, is_full=False)
        return pairs

    def _may_be_bent(self, matches: Sequence[Match], pairs: Mapping[int, _Pair]) -> bool:
        """Decide whether the query may be a bent part of a shape other than the best."""
        _, pair = _nearest(matches, pairs)
        if pair is not None and pair.alignment is not None and covers_whole(self._settings, pair.alignment):
            return False
        likeliest = max(matches, key=lambda match: match.similarity)
        # A relative in the query's pose agrees with it, but does not fit exactly.
        pair = pairs.get(likeliest.shape_id)
        fits = pair is not None and pair.exact >= self._settings.bent_exact
        return likeliest.similarity < self._settings.likely or not fits

    def _with_bent(
        self, samples: QuerySamples, matches: Sequence[Match], pairs: Mapping[int, _Pair]
    ) -> list[Match]:
        """Change the distances of matches by whether the query may be a part of them in another pose."""
        differences: dict[int, float] = {}
        surfaces = remembered(self._surfaces, samples.surfaces)
        for example in samples.examples:
            if example.prepared.bent is not None:
                own = [match.shape_id for match in matches if samples.of(match) is example]
                known = {
                    shape_id: sample.local_heat
                    for shape_id, sample in surfaces(own)
                    if sample.local_heat is not None
                }
                differences |= example.prepared.bent.differences(known)
        # Where heat finds nothing that is more likely than not, it says nothing against an alignment.
        nearest, pair = _nearest(matches, pairs)
        if (
            min(differences.values(), default=math.inf) >= self._settings.bent_half
            and pair is not None
            and nearest.distance < _FOUND * pair.match.distance
        ):
            return list(matches)
        return [
            self._if_bent(match, differences[match.shape_id], pairs.get(match.shape_id))
            if match.shape_id in differences
            else match
            for match in matches
        ]

    def _if_bent(self, match: Match, difference: float, pair: _Pair | None) -> Match:
        bags = match.distance if pair is None else pair.match.distance
        exact = 0.0 if pair is None else pair.exact
        distance = bent_distance(self._model, self._settings, match.distance, bags, exact, difference)
        if distance == match.distance:
            return replace(match, bent_distance=distance)
        similarity = self._model.similarity(distance, match.typical_distance, verified=True)
        return replace(match, distance=distance, bent_distance=distance, similarity=float(similarity))

    def _distance(self, pair: _Pair) -> float:
        """Lower the distance of the bags by how well the surfaces fit."""
        if pair.alignment is None:
            return pair.match.distance
        return lowered_distance(self._model, self._settings, pair.match.distance, pair.alignment, pair.exact)

    def _verified(self, samples: QuerySamples, pair: _Pair) -> Match:
        if pair.alignment is None:
            return pair.match
        distance = self._distance(pair)
        return replace(
            pair.match,
            distance=distance,
            similarity=float(self._model.similarity(distance, pair.match.typical_distance, verified=True)),
            alignment=pair.alignment if pair.is_full else None,
            aligned_sample=_sample_key(samples.of(pair.match).prepared.sample),
        )


def _nearest(matches: Sequence[Match], pairs: Mapping[int, _Pair]) -> tuple[Match, _Pair | None]:
    """Return the nearest match, and its alignment if it was aligned."""
    nearest = min(matches, key=lambda match: match.rank_key)
    return nearest, pairs.get(nearest.shape_id)


def verify_pair(
    model: ShapeModel,
    settings: VerificationSettings,
    query: QuerySample,
    candidate: PreparedSample,
    distance: float,
    typical: float | None = None,
    known: Alignment | None = None,
) -> tuple[float, Alignment]:
    """Verify one pair, as thoroughly as a search would verify any of its candidates.

    Parameters
    ----------
    model : ShapeModel
    settings : VerificationSettings
    query : QuerySample
    candidate : PreparedSample
    distance : float
        Distance of the bags.
    typical : float, optional
        Typical distance of the two, see `ShapeModel.typical_distances`.
    known : Alignment, optional
        From `align`, if it is known already.

    Returns
    -------
    distance : float
        Lowered by how well the surfaces fit.
    alignment : Alignment
        From the query to the candidate.
    """
    alignment = align(query.prepared, candidate) if known is None else known
    exact, _ = fit_exactly(query.prepared, candidate, alignment.frame)
    lowered = lowered_distance(model, settings, distance, alignment, exact)
    if float(model.similarity(lowered, typical, verified=True)) >= settings.likely:
        return lowered, alignment
    (pose,) = rough_poses(query.shared, [candidate.sample], [range(len(SHARED_SCALES))])
    frame = pose.frame
    if frame is not None:
        exact, frame = fit_exactly(query.shared, candidate, frame)
        other = measure(query.shared, candidate, frame)
        again = lowered_distance(model, settings, distance, other, exact)
        if again < lowered:
            return again, other
    return lowered, alignment


def _sample_key(sample: SurfaceSample) -> int:
    """Compute a checksum that identifies a sample, the same in every process."""
    return zlib.crc32(sample.points.tobytes())


def known_alignment(match: Match, sample: SurfaceSample) -> Alignment | None:
    """Return the alignment of a sample with a match, if verification has found one.

    Parameters
    ----------
    match : Match
    sample : SurfaceSample
        Of the query.

    Returns
    -------
    alignment : Alignment or None
        None for matches of another query too.
    """
    return match.alignment if match.aligned_sample == _sample_key(sample) else None
