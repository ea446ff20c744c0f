# SPDX-License-Identifier: MIT
"""Parts in another pose: how much the local heat of a query differs from that of candidates.

A bent part fits no whole rigidly, and its bags depend on what is missing. Its local heat does not.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.registration.heat.agreement import HeatStack, PartHeat, whitened_heat
from shapegoogle_core.registration.heat.local_heat import LocalHeat

__all__ = ["BACKGROUND_FILE", "FEW_AMONG", "BentPart"]

BACKGROUND_FILE = "background.npz"
"""Local heat of the shapes that every difference is compared with, in this folder."""

# Sizes of a part that are tried, as shares of its own: down to a third of the area of its whole.
_SIZES = 1.05 ** -np.arange(12.0)
# All candidates are compared roughly: few points of the query at every second size, with few of the
# candidate. The best are compared closely, near the size found. What is found of a pair does not depend on
# the other shapes.
_FEW, _CLOSELY, _MANY = 64, 64, 400
FEW_AMONG = 384
"""Number of the first points of a candidate that are compared roughly."""

# Candidates compared together, so that their matrices stay small.
_AT_ONCE = 16


class BentPart:
    """A query that is cut off somewhere, compared with the local heat of candidates.

    A tube differs little from many shapes, an insect from all but insects. So a difference is given as a
    multiple of the least one from a fixed background of creatures and things.

    Parameters
    ----------
    heat : LocalHeat
        Of the query.
    """

    def __init__(self, heat: LocalHeat) -> None:
        self._heat = heat

    def differences(self, candidates: Mapping[int, LocalHeat]) -> dict[int, float]:
        """Measure how much the query differs from candidates.

        Parameters
        ----------
        candidates : mapping of int to LocalHeat
            By shape id.

        Returns
        -------
        differences : dict of int to float
            By shape id, of those that differ least: multiples of the least difference from the background,
            see `PartHeat.differences`. Empty if too few points of the query are far enough from a cut.
        """
        usual = self._usual
        if not candidates or not math.isfinite(usual):
            return {}
        ids = list(candidates)
        rough = self._rough(_stacks([candidates[shape_id].first(FEW_AMONG) for shape_id in ids]))
        best = sorted(range(len(ids)), key=lambda row: (float(rough[row].min()), ids[row]))[:_CLOSELY]
        return {ids[row]: self._close(candidates[ids[row]], int(rough[row].argmin())) / usual for row in best}

    def difference(self, candidate: LocalHeat) -> float:
        """Measure how much the query differs from one candidate.

        Parameters
        ----------
        candidate : LocalHeat

        Returns
        -------
        difference : float
            As in `differences`; infinite if too few points of the query are far enough from a cut.
        """
        return self.differences({0: candidate}).get(0, math.inf)

    @cached_property
    def _usual(self) -> float:
        """Least difference from the background."""
        return float(self._rough(_background()).min())

    @cached_property
    def _rough_parts(self) -> list[PartHeat]:
        return [PartHeat(self._heat, float(size), _FEW) for size in _SIZES[::2]]

    @cached_property
    def _close_parts(self) -> list[PartHeat]:
        return [PartHeat(self._heat, float(size), _MANY) for size in _SIZES]

    def _rough(self, candidates: Iterable[HeatStack]) -> NDArray[np.float32]:
        """Compute differences from a few points: a row for each candidate, a column for every second size."""
        found = [
            np.stack([part.differences(stack) for part in self._rough_parts], axis=1) for stack in candidates
        ]
        return np.concatenate(found)

    def _close(self, candidate: LocalHeat, rough_size: int) -> float:
        """Compute the least difference near the size at which it is roughly least."""
        among = HeatStack(whitened_heat(candidate)[None])
        sizes = self._close_parts[max(0, 2 * rough_size - 1) : 2 * rough_size + 2]
        return min(float(part.differences(among)[0]) for part in sizes)


def _stacks(candidates: Sequence[LocalHeat]) -> Iterator[HeatStack]:
    for start in range(0, len(candidates), _AT_ONCE):
        yield HeatStack(np.stack([whitened_heat(heat) for heat in candidates[start : start + _AT_ONCE]]))


@cache
def _background() -> list[HeatStack]:
    with (files(__package__) / BACKGROUND_FILE).open("rb") as stream, np.load(stream) as arrays:
        return list(_stacks([LocalHeat.from_bytes(row.tobytes()) for row in arrays["shapes"]]))
