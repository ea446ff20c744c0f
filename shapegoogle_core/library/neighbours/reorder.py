# SPDX-License-Identifier: MIT
"""Matches in the order of a walk over the neighbour graph."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match
from shapegoogle_core.library.neighbours.graph import NeighbourGraph

__all__ = ["reorder"]


def reorder(graph: NeighbourGraph, matches: Sequence[Match]) -> list[Match]:
    """Let a walk from the query order the matches behind the first few.

    The distances of those that it visits are lowered, so that `Match.distance` remains what the list is
    sorted by. Similarities stay those of the pairs.

    Parameters
    ----------
    graph : NeighbourGraph
    matches : sequence of Match
        Best first.

    Returns
    -------
    matches : list of Match
    """
    distances = graph.distances(
        [match.shape_id for match in matches], [match.distance for match in matches]
    ).round(DISTANCE_DECIMALS)
    walked = [
        match if match.distance == distance else replace(match, distance=distance)
        for match, distance in zip(matches, distances.tolist(), strict=True)
    ]
    # Stable: copies at the least distance have an order of their own.
    return sorted(walked, key=lambda match: match.distance)
