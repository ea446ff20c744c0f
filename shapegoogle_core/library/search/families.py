# SPDX-License-Identifier: MIT
"""Families of matches: shapes that are the same to a user, of which the best stands for all.

A library may hold hundreds of versions of one shape: copies, other sizes and poses, finer and coarser
meshes. Leader clustering over the ranked matches keeps the best of each family in front. Whether two shapes
are of one family depends on these two and the model only: their bags are near, and so are the lowest
eigenvalues of their surfaces. Bags alone confuse plain shapes, such as a cube and a ball
(docs/measurements/search.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match
from shapegoogle_core.library.search.settings import FamilySettings
from shapegoogle_core.library.search.surfaces import stored_samples
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.registration import SurfaceSample, spectral_difference

__all__ = ["Families", "Family", "collect_families", "families_accepted"]


# Matches that are explained at once to find those of a kind.
_EXPLAINED_AT_ONCE = 10


@dataclass(eq=False)
class Family:
    """Matches that are one shape.

    Attributes
    ----------
    members : list of Match
        In the order in which they were met; the first is the leader, which all others are compared with.
    vector : (1, b) array
        The leader's bags, ready to be compared.
    background_distance : float or None
        Of the leader, see `ShapeModel.background_distances`.
    """

    members: list[Match]
    vector: FloatBags
    background_distance: float | None = None

    @property
    def best(self) -> Match:
        """The best member, with the others as its versions; of equally near ones the first that was met."""
        return self.shown_by(min(self.members, key=attrgetter("distance")))

    def shown_by(self, member: Match) -> Match:
        """Let a member stand for all: the others are its versions."""
        others = tuple(match.shape_id for match in self.members if match.shape_id != member.shape_id)
        return replace(member, versions=len(others), version_ids=others)


class Families:
    """Clusters matches around the best of each family.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    settings : FamilySettings

    Attributes
    ----------
    families : list of Family
        In the order in which their leaders were met.
    most_met : int
        Number of matches to go through at most.
    """

    def __init__(self, store: Store, model: ShapeModel, settings: FamilySettings) -> None:
        self._store = store
        self._model = model
        self._settings = settings
        self.most_met = settings.most_met
        self.families: list[Family] = []
        self._leader_samples: dict[int, SurfaceSample | None] = {}

    def take(self, matches: Sequence[Match], wanted: int) -> None:
        """Let matches join families, or begin new ones as long as fewer than wanted are known.

        Parameters
        ----------
        matches : sequence of Match
            Best first. Those that were removed meanwhile are left out.
        wanted : int
            Number of families.
        """
        for start in range(0, len(matches), self._settings.at_once):
            self._take(matches[start : start + self._settings.at_once], wanted)

    def _take(self, matches: Sequence[Match], wanted: int) -> None:
        shape_ids, bags = self._store.bags([match.shape_id for match in matches], self._model.bag_size)
        rows = {shape_id: row for row, shape_id in enumerate(shape_ids)}
        matches = [match for match in matches if match.shape_id in rows]
        if not matches:
            return
        bags = bags[[rows[match.shape_id] for match in matches]]
        vectors, plain = self._model.comparable(bags), self._model.background_distances(bags)
        near = [self._near(family, vectors, plain) for family in self.families]
        for row, match in enumerate(matches):
            candidates = [family for family, is_near in zip(self.families, near, strict=True) if is_near[row]]
            # Few have near bags, so only the surfaces of these are read.
            sample = self._sample(match) if candidates else None
            known = next((family for family in candidates if self._same_surface(family, sample)), None)
            if known is not None:
                known.members.append(match)
            elif len(self.families) < wanted:
                own = None if plain is None else float(plain[row])
                family = Family([match], vectors[row : row + 1], own)
                self.families.append(family)
                near.append(self._near(family, vectors, plain))

    def _near(self, family: Family, vectors: FloatBags, plain: FloatArray | None) -> NDArray[np.bool_]:
        """Whether the bags of shapes (n,) are near those of a leader."""
        distances = row_distances(self._model.settings.metric, family.vector, vectors)
        own = family.background_distance
        typical = None if plain is None or own is None else np.sqrt(own * plain)
        similarities = self._model.similarity(np.round(distances, DISTANCE_DECIMALS), typical)
        return np.asarray(similarities >= self._settings.min_similarity)

    def _sample(self, match: Match) -> SurfaceSample | None:
        return dict(stored_samples(self._store, self._model, [match.shape_id])).get(match.shape_id)

    def _same_surface(self, family: Family, sample: SurfaceSample | None) -> bool:
        """Whether the lowest eigenvalues are near; true where a surface is not known."""
        leader = family.members[0]
        if leader.shape_id not in self._leader_samples:
            self._leader_samples[leader.shape_id] = self._sample(leader)
        known = self._leader_samples[leader.shape_id]
        if known is None or sample is None:
            return True
        return spectral_difference(known, sample) <= self._settings.max_spectral_difference


def collect_families(
    families: Families,
    wanted: int,
    first: Sequence[Match],
    more: Callable[[int], Sequence[Match]],
    total: int,
) -> list[Family]:
    """Go through the matches of a search until enough families are found.

    Parameters
    ----------
    families : Families
    wanted : int
        Number of families.
    first : sequence of Match
        The best matches of the search.
    more : callable
        Returns this number of best matches, or all there are.
    total : int
        Number of shapes that are searched.

    Returns
    -------
    families : list of Family
        Best first: at most as many as are wanted.
    """
    known: set[int] = set()
    matches, count = first[: families.most_met], len(first)
    while True:
        new = [match for match in matches if match.shape_id not in known]
        known.update(match.shape_id for match in new)
        families.take(new, wanted)
        enough = len(families.families) >= wanted
        last = not new or count >= min(total, families.most_met)
        if enough or last:
            found = sorted(families.families, key=lambda family: family.best.distance)
            return found[:wanted]
        count = min(4 * count, total, families.most_met)
        matches = more(count)


def families_accepted(
    families: Sequence[Family],
    accepts: Callable[[Match], bool],
    explain: Callable[[Sequence[Match]], Sequence[Match]],
    wanted: int,
    most: int,
) -> list[Match]:
    """Find the families with a member that meets conditions on its evidence or similarity.

    The first member of every family is explained before the second of any, so that a family with hundreds of
    members does not use up the number that may be explained.

    Parameters
    ----------
    families : sequence of Family
        Best first.
    accepts : callable
        Whether a match with its final figures meets the conditions.
    explain : callable
        Adds these figures to matches.
    wanted : int
        Number of families.
    most : int
        Number of matches to explain at most.

    Returns
    -------
    matches : list of Match
        For each family the first accepted member, with the others as versions; best first.
    """
    ordered = [sorted(family.members, key=attrgetter("distance")) for family in families]
    turns = sorted((turn, number) for number, members in enumerate(ordered) for turn in range(len(members)))
    found: dict[int, Match] = {}
    for start in range(0, min(most, len(turns)), _EXPLAINED_AT_ONCE):
        portion = turns[start : min(start + _EXPLAINED_AT_ONCE, most)]
        asked = [(number, ordered[number][turn]) for turn, number in portion if number not in found]
        explained = explain([match for _, match in asked])
        for (number, _), match in zip(asked, explained, strict=True):
            if number not in found and accepts(match):
                found[number] = families[number].shown_by(match)
        if len(found) >= wanted:
            break
    in_order = [found[number] for number in sorted(found)]
    return sorted(in_order, key=attrgetter("distance"))[:wanted]
