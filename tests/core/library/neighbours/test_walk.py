# SPDX-License-Identifier: MIT
"""The walk over a neighbour graph, on small graphs of points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import sparse

from shapegoogle_core.library.neighbours.walk import (
    link_weights,
    links_of,
    links_of_all,
    visits,
    walked_distances,
)
from shapegoogle_core.library.search.settings import WalkSettings

SETTINGS = WalkSettings()


def distances_of(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(points[:, None] - points[None], axis=-1))


@given(st.lists(st.tuples(st.integers(0, 4), st.sampled_from([0.0, 1e-7, 0.1, 0.2, 0.3])), max_size=40))
def test_links_of_several_shapes_are_those_of_each(pairs: list[tuple[int, float]]) -> None:
    owners = np.array([owner for owner, _ in pairs], int)
    lengths = np.array([length for _, length in pairs])
    expected = [
        own[links_of(lengths[own], SETTINGS)].tolist()
        for own in (np.flatnonzero(owners == owner) for owner in range(5))
    ]
    assert links_of_all(owners, lengths, SETTINGS).tolist() == [place for own in expected for place in own]


def graph(distances: NDArray[np.float64], settings: WalkSettings = SETTINGS) -> sparse.csr_array:
    """Link every point with its nearest ones."""
    firsts, seconds, lengths = [], [], []
    for number, row in enumerate(distances):
        others = np.delete(np.arange(len(row)), number)
        chosen = others[links_of(row[others], settings)]
        firsts += [number] * len(chosen)
        seconds += chosen.tolist()
        lengths += row[chosen].tolist()
    return link_weights(firsts, seconds, lengths, len(distances))


def ring(count: int, radius: float, height: float) -> NDArray[np.float64]:
    angles = 2 * np.pi * np.arange(count) / count
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(count, height)], axis=1)


def order_from(points: NDArray[np.float64], start: int, settings: WalkSettings = SETTINGS) -> list[int]:
    """Points in the order of the walk, the start left out."""
    distances = distances_of(points)
    nearest = [number for number in np.argsort(distances[start], kind="stable") if number != start]
    visited = visits(graph(distances, settings), start, settings.damping)
    order = np.argsort(walked_distances(distances[start][nearest], visited[nearest], settings), kind="stable")
    return [int(nearest[position]) for position in order]


def test_the_walk_follows_a_chain_past_nearer_shapes() -> None:
    # The far side of the start's own ring is farther away than all of the other ring's near side.
    points = np.concatenate([ring(12, 1, 0), ring(12, 1, 1.2)])
    by_distance = np.argsort(distances_of(points)[0])[1:12]
    assert (by_distance >= 12).sum() == 5
    assert sorted(order_from(points, 0)[:11]) == list(range(1, 12))


def test_the_first_few_stay_in_the_order_of_their_distances() -> None:
    points = np.random.default_rng(0).normal(size=(40, 3))
    by_distance = np.argsort(distances_of(points)[7])[1:].tolist()
    for first in (0, 3, 10):
        order = order_from(points, 7, replace(SETTINGS, unchanged=first))
        assert order[:first] == by_distance[:first]
        assert sorted(order) == sorted(by_distance)


def test_copies_do_not_trap_the_walk() -> None:
    points = np.concatenate([np.repeat(ring(12, 1, 0)[:1], 20, axis=0), ring(12, 1, 0)[1:]])
    visited = visits(graph(distances_of(points)), 0, SETTINGS.damping)
    assert (visited[20:] > 0).all()


def test_shapes_that_no_link_reaches_keep_the_order_of_their_distances() -> None:
    points = np.concatenate([ring(8, 1, 0), [[100.0 + number, 0, 0] for number in range(8)]])
    assert order_from(points, 0)[7:] == list(range(8, 16))


def test_visits_solve_the_equation_of_the_walk() -> None:
    weights = graph(distances_of(np.random.default_rng(1).normal(size=(25, 2))))
    dense = np.linalg.inv(np.eye(25) - 0.9 * weights.toarray())
    np.testing.assert_allclose(visits(weights, 3, 0.9), dense[3], atol=0.01)


def test_only_the_start_is_visited_without_links() -> None:
    nothing = link_weights([], [], [], 3)
    assert visits(nothing, 1, 0.95).tolist() == [0, 1, 0]
    assert walked_distances([0.1, 0.2], [0, 0], SETTINGS).tolist() == [0.1, 0.2]
    assert walked_distances([], [], SETTINGS).tolist() == []


@given(st.integers(2, 30), st.integers(0, 2**32 - 1))
def test_weights_are_those_of_a_walk(count: int, seed: int) -> None:
    points = np.random.default_rng(seed).integers(0, 4, (count, 2)).astype(float)  # many copies
    weights = graph(distances_of(points)).toarray()
    np.testing.assert_allclose(weights, weights.T, atol=1e-12)
    assert (weights >= 0).all()
    assert np.abs(np.linalg.eigvalsh(weights)).max() < 1 + 1e-9
    assert np.isfinite(weights).all()


@pytest.mark.parametrize("copies", [0, 1, 2])
def test_copies_are_linked_besides_the_neighbours(copies: int) -> None:
    settings = WalkSettings(links=2, copies=copies)
    chosen = links_of([0, 0, 0, 0.5, 0.3, 0.4], settings)
    assert chosen.tolist() == [*range(copies), 4, 5]


def test_copies_of_the_query_stay_before_all_others() -> None:
    distances = walked_distances([0, 0, 0, 0.1, 0.2], [0.1, 0, 0, 0.2, 5], WalkSettings(unchanged=0))
    assert distances[:3].tolist() == [0, 0, 0]
    assert 0 < distances[4] < distances[3] < 0.1


@given(st.lists(st.tuples(st.floats(0, 2), st.floats(0, 10)), max_size=20), st.integers(0, 5))
def test_distances_are_only_lowered_and_never_below_the_first_few(
    matches: list[tuple[float, float]], first: int
) -> None:
    distances = np.sort([distance for distance, _ in matches])
    settings = WalkSettings(unchanged=first)
    walked = walked_distances(distances, [visited for _, visited in matches], settings)
    assert (walked <= distances + 1e-12).all()
    assert (walked[:first] == distances[:first]).all()
    assert (walked[first:] >= distances[:first].max(initial=0) - 1e-12).all()
