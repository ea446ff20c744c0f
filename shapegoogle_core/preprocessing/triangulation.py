# SPDX-License-Identifier: MIT
"""Edges of a triangulation; splitting them, and flipping them inside flat regions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.connectivity import sorted_pairs
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["EdgeTable", "Indices", "edge_table", "flip_edges", "split_edges"]

FLIP_TOLERANCE = 1e-9
MOST_FLIP_ROUNDS = 100  # ends sooner but for rounding

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class EdgeTable:
    """Edges of a triangulation. Side 3f + c of face f lies opposite its corner c.

    Attributes
    ----------
    ends : (e, 2) array of int
        Vertices of each edge, the smaller index first.
    of_side : (m, 3) array of int
        Edge opposite each corner.
    first, last : (e,) array of int
        First and last side on each edge; they are equal on an open boundary.
    between_two : (e,) array of bool
        Whether an edge has exactly two faces, which run along it in opposite directions.
    """

    ends: Indices
    of_side: Indices
    first: Indices
    last: Indices
    between_two: NDArray[np.bool_]

    def inside(self, region: Indices) -> NDArray[np.bool_]:
        """Find the edges between two faces of one region.

        Parameters
        ----------
        region : (m,) array of int
            Region of each face.

        Returns
        -------
        inside : (e,) array of bool
        """
        return np.asarray(self.between_two & (region[self.first // 3] == region[self.last // 3]))


def edge_table(faces: Indices) -> EdgeTable:
    """Find the edges of a triangulation.

    Parameters
    ----------
    faces : (m, 3) array of int

    Returns
    -------
    edges : EdgeTable
    """
    corners = faces.astype(np.int32)
    tail, head = corners.take([1, 2, 0], axis=1).ravel(), corners.take([2, 0, 1], axis=1).ravel()
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    order = sorted_pairs(low, high, int(faces.max()) + 1).astype(np.int64)
    low, high = low.take(order), high.take(order)
    is_new = np.ones(len(order), bool)
    is_new[1:] = (low[1:] != low[:-1]) | (high[1:] != high[:-1])
    of_side = np.empty(len(order), np.int64)
    start = np.flatnonzero(is_new)
    stop = np.append(start[1:], len(order))
    of_side[order] = np.repeat(np.arange(len(start)), stop - start)
    first, last = order[start], order[stop - 1]
    return EdgeTable(
        np.stack([low[start], high[start]], axis=1).astype(np.int64),
        of_side.reshape(-1, 3),
        first,
        last,
        (stop - start == 2) & (tail[first] != tail[last]),
    )


def split_edges(
    vertices: FloatArray, faces: Indices, region: Indices, edges: EdgeTable, chosen: NDArray[np.bool_]
) -> tuple[FloatArray, Indices, Indices, NDArray[np.bool_]]:
    """Split edges at their midpoints, and with them all their faces.

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array of int
    region : (m,) array of int
        Region of each face.
    edges : EdgeTable
        Edges of `faces`.
    chosen : (e,) array of bool
        Edges to split.

    Returns
    -------
    vertices : (n + k, 3) array
        The same vertices first.
    faces : (p, 3) array of int
    region : (p,) array of int
        New faces belong to the regions of those that they are parts of.
    new : (p,) array of bool
        Faces that were not there before.
    """
    midpoints = vertices[edges.ends[chosen]].mean(axis=1)
    midpoint_of_edge = np.full(len(edges.ends), -1)
    midpoint_of_edge[chosen] = len(vertices) + np.arange(len(midpoints))
    vertices = np.concatenate([vertices, midpoints])
    midpoint = midpoint_of_edge[edges.of_side]  # opposite each corner; -1: not split
    count = (midpoint.T >= 0).astype(np.int8, order="C").sum(axis=0)
    new_faces, new_regions = [faces[count == 0]], [region[count == 0]]

    def add(which: NDArray[np.bool_], *corners: tuple[Indices, Indices, Indices]) -> None:
        new_faces.extend(np.stack(each, axis=1) for each in corners)
        new_regions.extend([region[which]] * len(corners))

    # One edge split: two faces. Opposite the first corner: the split edge.
    a, b, c, ma, _, _ = _turn(faces, midpoint, count == 1, split=True)
    add(count == 1, (a, b, ma), (a, ma, c))
    # Two: a corner, and the rest along one of its diagonals. Opposite the first corner: the whole edge.
    a, b, c, _, mb, mc = _turn(faces, midpoint, count == 2, split=False)
    add(count == 2, (a, mc, mb), (mc, b, mb), (b, c, mb))
    # Three: four faces.
    a, b, c, ma, mb, mc = _turn(faces, midpoint, count == 3, split=False)
    add(count == 3, (a, mc, mb), (mc, b, ma), (mb, ma, c), (ma, mb, mc))
    faces, region = np.concatenate(new_faces), np.concatenate(new_regions)
    return vertices, faces, region, np.arange(len(faces)) >= len(new_faces[0])


def _turn(faces: Indices, midpoint: Indices, which: NDArray[np.bool_], *, split: bool) -> Indices:
    """Corners of some faces and the midpoints opposite, (6, k).

    They are turned so that an edge that is split, or one that is not, lies opposite the first corner.
    """
    rows = np.flatnonzero(which)[:, None]
    first = np.argmax((midpoint[which] >= 0) == split, axis=1)[:, None]
    order = (first + np.arange(3)) % 3
    return np.concatenate([faces[rows, order], midpoint[rows, order]], axis=1).T


def flip_edges(
    vertices: FloatArray, faces: Indices, region: Indices, changed: NDArray[np.bool_] | None = None
) -> Indices:
    """Flip edges inside flat regions until every triangle is Delaunay in its plane (Lawson 1977).

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array of int
    region : (m,) array of int
        Region of each face. All faces of a region lie in one plane.
    changed : (m,) array of bool, optional
        Faces that may not be Delaunay; by default all.

    Returns
    -------
    flipped : (m, 3) array of int
        Each face is still in its region.
    """
    if changed is None:
        return _flipped(vertices, faces, region, np.ones(len(faces), bool))
    # Nothing changes in the other regions. Their faces count where they share an edge with those that may
    # change, since an edge of more than two faces is not flipped.
    touched = np.zeros(int(region.max()) + 1, bool)
    touched[region[changed]] = True
    corners = np.zeros(len(vertices), bool)
    corners[faces[touched[region]]] = True
    part = np.flatnonzero(corners.take(faces.T).sum(axis=0) >= 2)
    faces = faces.copy()
    faces[part] = _flipped(vertices, faces[part], region[part], changed[part])
    return faces


def _flipped(vertices: FloatArray, faces: Indices, region: Indices, changed: NDArray[np.bool_]) -> Indices:
    """Flip edges as in `flip_edges`, beginning with those of changed faces."""
    if not changed.any():
        return faces
    edges = edge_table(faces)
    inside = edges.inside(region)
    twin = np.full(faces.size, -1)  # the side across each edge that may be flipped
    twin[edges.first[inside]] = edges.last[inside]
    twin[edges.last[inside]] = edges.first[inside]
    sides = edges.first[inside]
    sides = sides[changed[sides // 3] | changed[twin[sides] // 3]]
    if len(sides) == 0:
        return faces
    faces = faces.copy()
    # Of faces that are regions of their own no cotangents are needed.
    flippable = (twin.reshape(-1, 3) >= 0).any(axis=1)
    cotangents = np.empty(faces.size)
    cotangents.reshape(-1, 3)[flippable] = _opposite_cotangents(vertices, faces[flippable])
    for _ in range(MOST_FLIP_ROUNDS):
        total = cotangents[sides] + cotangents[twin[sides]]
        # Each face takes part in its most urgent flip only, and only if its neighbour's is the same.
        urgent = np.flatnonzero(total < -FLIP_TOLERANCE)
        if len(urgent) == 0:
            break
        urgent = urgent[np.argsort(total[urgent], kind="stable")]
        one = sides[urgent]
        other = twin[one]
        best = np.full(len(faces), len(urgent))
        rank = np.arange(len(urgent))
        np.minimum.at(best, one // 3, rank)
        np.minimum.at(best, other // 3, rank)
        agreed = (best[one // 3] == rank) & (best[other // 3] == rank)
        flipped = _flip(faces, twin, one[agreed], other[agreed])
        cotangents.reshape(-1, 3)[flipped] = _opposite_cotangents(vertices, faces[flipped])
        # Edges that wait for their turn, and those of the faces that are new.
        near = np.concatenate([(3 * flipped[:, None] + np.arange(3)).ravel(), one[~agreed]])
        near = near[twin[near] >= 0]
        sides = np.unique(np.minimum(near, twin[near]))
    return faces


def _flip(faces: Indices, twin: Indices, one: Indices, other: Indices) -> Indices:
    """Flip edges, given by their two sides, in place; return the numbers of the faces beside them."""
    first, second = one // 3, other // 3
    p, i, j = (faces[first, (one % 3 + step) % 3] for step in range(3))
    q = faces[second, other % 3]
    # The four sides around each edge keep their twins, but get other places.
    before = np.concatenate(
        [
            3 * second + (other % 3 + 1) % 3,  # from i to q
            3 * first + (one % 3 + 2) % 3,  # from p to i
            3 * first + (one % 3 + 1) % 3,  # from j to p
            3 * second + (other % 3 + 2) % 3,  # from q to j
        ]
    )
    after = np.concatenate([3 * first, 3 * first + 2, 3 * second, 3 * second + 2])
    place = np.arange(len(twin))
    place[before] = after
    across = twin[before]
    has_twin = across >= 0
    across[has_twin] = place[across[has_twin]]
    twin[after] = across
    twin[across[has_twin]] = after[has_twin]
    twin[3 * first + 1], twin[3 * second + 1] = 3 * second + 1, 3 * first + 1
    faces[first] = np.stack([p, i, q], axis=1)
    faces[second] = np.stack([q, j, p], axis=1)
    return np.concatenate([first, second])


def _opposite_cotangents(vertices: FloatArray, faces: Indices) -> FloatArray:
    """Cotangent of the angle at each corner, (m, 3)."""
    corners = vertices[faces]
    to_next = corners[:, [1, 2, 0]] - corners
    to_last = corners[:, [2, 0, 1]] - corners
    x, y, z = to_next[:, 0].T
    u, v, w = to_last[:, 0].T
    double_area = np.sqrt((y * w - z * v) ** 2 + (z * u - x * w) ** 2 + (x * v - y * u) ** 2)
    # A face without area has the cotangents of a very low one.
    longest = np.einsum("fcx,fcx->fc", to_next, to_next).max(axis=1)
    inner = np.einsum("fcx,fcx->fc", to_next, to_last)
    return np.asarray(inner / np.maximum(double_area, 1e-12 * longest)[:, None])
