# SPDX-License-Identifier: MIT
"""Matches in the order of a walk over the neighbour graph."""

from __future__ import annotations

from collections.abc import Sequence

from shapegoogle_core.library.match import Match
from shapegoogle_core.library.neighbours.graph import NeighbourGraph
from shapegoogle_core.library.search.query import Query
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["WalkReranker"]


class WalkReranker:
    """Lets a walk from the query order the matches behind the first few; a `MatchReranker`.

    Parameters
    ----------
    graph : NeighbourGraph
    """

    def __init__(self, graph: NeighbourGraph) -> None:
        self._graph = graph

    def distances(self, query: Query, matches: Sequence[Match]) -> FloatArray:  # noqa: ARG002 - as in the protocol
        """Lower the distances of the matches that the walk visits.

        Parameters
        ----------
        query : Query
        matches : sequence of Match
            Best first.

        Returns
        -------
        distances : (n,) array
        """
        return self._graph.distances(
            [match.shape_id for match in matches], [match.distance for match in matches]
        )
