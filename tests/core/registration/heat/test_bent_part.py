# SPDX-License-Identifier: MIT
"""A part in another pose differs least from its whole."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from benchmarks.creatures import make_creature
from benchmarks.experiments.evidence_pairs import cut
from shapegoogle_core import Mesh
from shapegoogle_core.registration import (
    BentPart,
    HeatStack,
    LocalHeat,
    PartHeat,
    PreparedSample,
    whitened_heat,
)
from tests.core.registration.heat.test_local_heat import heat_of, sample_of

KINDS = ("horse", "spider", "octopus", "bird", "human")
SEED = 303


@cache
def whole(kind: str, seed: int = SEED) -> LocalHeat:
    return heat_of(make_creature(kind, seed, 3000).pose(0))


def bent(kind: str, share: float) -> Mesh:
    return cut(make_creature(kind, SEED, 3000).pose(1), np.array([0.3, 0.2, 1.0]), share)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("share", "first"), [(2 / 3, 1), (1 / 2, 2)])
def test_it_is_found_among_others(kind: str, share: float, first: int) -> None:
    heats = {number: whole(other) for number, other in enumerate(KINDS)}
    found = BentPart(heat_of(bent(kind, share))).differences(heats)
    assert KINDS.index(kind) in sorted(found, key=lambda number: found[number])[:first]


def test_a_difference_does_not_depend_on_other_shapes() -> None:
    part = BentPart(heat_of(bent("horse", 2 / 3)))
    alone = part.difference(whole("horse"))
    together = part.differences({number: whole(kind) for number, kind in enumerate(KINDS)})
    assert together[0] == pytest.approx(alone, rel=1e-5)
    assert BentPart(heat_of(bent("horse", 2 / 3))).difference(whole("horse")) == alone


def test_a_surface_does_not_differ_from_itself() -> None:
    heat = whole("horse")
    whitened = HeatStack(whitened_heat(heat)[None])
    assert float(PartHeat(heat, 1.0, 400).differences(whitened)[0]) == pytest.approx(0, abs=1e-3)
    assert float(PartHeat(heat, 0.8, 400).differences(whitened)[0]) > 0.05


@given(
    features=arrays(np.float32, (3, 5, 6), elements=st.floats(-9, 9, width=32)),
    rows=arrays(np.float32, (4, 6), elements=st.floats(-9, 9, width=32)),
    numbers=st.integers(2, 6),
)
def test_the_nearest_rows_are_those_of_all_distances(
    features: NDArray[np.float32], rows: NDArray[np.float32], numbers: int
) -> None:
    apart = rows[:, None, None, :numbers].astype(float) - features[None, :, :, :numbers]
    expected = (apart**2).sum(axis=3).min(axis=2)
    stack = HeatStack(features)
    for _ in range(2):  # arranged, and then remembered
        assert stack.least_squares(rows[:, :numbers]) == pytest.approx(expected, abs=1e-3)


def test_nothing_is_asked_of_no_candidates() -> None:
    assert BentPart(heat_of(bent("horse", 2 / 3))).differences({}) == {}


def test_only_what_is_cut_off_is_a_part() -> None:
    closed = sample_of(make_creature("horse", SEED, 3000).pose(0))
    assert PreparedSample(closed).bent is None
    mesh = make_creature("horse", SEED, 3000).pose(0)
    pierced = sample_of(Mesh(mesh.vertices, mesh.faces[(mesh.faces != mesh.faces[0, 0]).all(axis=1)]))
    assert PreparedSample(pierced).bent is None
    opened = sample_of(bent("horse", 2 / 3))
    assert PreparedSample(opened).bent is not None


def test_a_scrap_says_nothing() -> None:
    grid = np.arange(64).reshape(8, 8)
    corners = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 4)
    faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    x, y = np.divmod(np.arange(64), 8)
    strip = Mesh(np.column_stack([x / 50, y, 0 * x]).astype(float), faces)
    part = BentPart(heat_of(strip))
    assert part.differences({0: whole("horse")}) == {}
    assert part.difference(whole("horse")) == np.inf
