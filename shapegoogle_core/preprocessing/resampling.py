# SPDX-License-Identifier: MIT
"""Resampling: every surface and every point cloud gets a working resolution."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh
from shapegoogle_core.preprocessing.repair import repair

__all__ = ["cell_numbers", "finest_cell", "resample", "simplify", "subdivide", "thin"]

# fast_simplification compares quadric errors with fixed numbers, from 2e-6 to 1e5 squared units in a
# hundred rounds. On a mesh of unit size it would allow every collapse after a dozen rounds and ruin the
# shape; on this diagonal the rounds go from 1e-7 to 0.04 of it.
COLLAPSED_DIAGONAL = 1e4
# A mesh is polygon soup if collapsing its edges ends this far above the budget, or if it has many parts and
# keeps less of its area than this. (One part that loses as much has lost noise.)
FAR_ABOVE_BUDGET = 1.1
LEAST_KEPT_AREA = 0.9
MANY_PARTS = 50
# After a collapse, repair can change the number of vertices: a second collapse aims a little lower.
SECOND_AIM = 0.99
GRID_STEPS = 16  # of bisection: the cell to 3e-5 of the longest side
THINNING_STEPS = 18  # the cell to 1e-5 of the longest side
CELLS_PER_SIDE = 1 << 20  # three coordinates fit into 64 bits

# New edges inside an old face are split later than its sides, so that a thin face becomes a zigzag between
# points on its sides; without that (and flips) it would become ever thinner faces.
INNER_EDGE = 1.5
LEAST_OF_ROUND = 0.75
FLIP_TOLERANCE = 1e-9
MOST_FLIP_ROUNDS = 100  # ends sooner but for rounding

Indices = NDArray[np.int64]


def resample(mesh: Mesh, floor: int = 1000, budget: int = 5000) -> Mesh:
    """Subdivide a mesh below the floor of vertices, simplify one above the budget.

    Parameters
    ----------
    mesh : Mesh
        Repaired. A point cloud is only thinned to the budget; see `thin`.
    floor : int, optional
        Fewest vertices wanted; see `subdivide`.
    budget : int, optional
        Most vertices; see `simplify`.

    Returns
    -------
    resampled : Mesh
        With `budget` vertices at most.
    """
    if mesh.is_point_cloud:
        return Mesh(thin(mesh.vertices, budget), name=mesh.name)
    if len(mesh.vertices) < floor:
        mesh = subdivide(mesh, floor)
    if len(mesh.vertices) > budget:
        mesh = simplify(mesh, budget)
    return mesh


def simplify(mesh: Mesh, budget: int) -> Mesh:
    """Simplify a mesh by collapsing edges, or polygon soup by merging vertices on a grid.

    Edges are collapsed by quadric error; those on open boundaries stay. That cannot simplify soup, whose
    many small sheets are all boundary. If the collapse ends above the budget, or takes more than a tenth of
    the area from a mesh of more than fifty parts, the vertices in each cell of a grid become one instead
    (Rossignac and Borrel 1993). This also joins sheets that lie against each other into one surface, which
    heat can cross. Leaves much smaller than a cell are lost.

    Parameters
    ----------
    mesh : Mesh
        Repaired.
    budget : int

    Returns
    -------
    simplified : Mesh
        Repaired, with `budget` vertices at most.
    """
    collapsed = _collapse(mesh, budget)
    if budget < len(collapsed.vertices) <= FAR_ABOVE_BUDGET * budget:
        collapsed = _collapse(collapsed, int(SECOND_AIM * budget))
    if len(collapsed.vertices) > budget:
        return _merge_on_grid(mesh, budget)
    if collapsed.area < LEAST_KEPT_AREA * mesh.area and _part_count(mesh) > MANY_PARTS:
        return _merge_on_grid(mesh, budget)
    return collapsed


def _collapse(mesh: Mesh, budget: int) -> Mesh:
    """Collapse edges by quadric error towards `budget` vertices; the same mesh if it has too few faces."""
    import fast_simplification

    # Collapsing an edge takes one vertex and the two faces beside it.
    target = len(mesh.faces) - 2 * (len(mesh.vertices) - budget)
    if target <= 0:
        return mesh
    origin = mesh.vertices.min(axis=0)
    unit = np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / COLLAPSED_DIAGONAL
    vertices, faces = fast_simplification.simplify(
        (mesh.vertices - origin) / unit, np.array(mesh.faces), target_count=target, preserve_border=True
    )
    return repair(Mesh(vertices * unit + origin, faces, mesh.name))


def _part_count(mesh: Mesh) -> int:
    count = len(mesh.vertices)
    start, end = mesh.faces[:, [0, 1]].ravel(), mesh.faces[:, [1, 2]].ravel()
    graph = coo_array((np.ones(len(start), np.int8), (start, end)), shape=(count, count))
    return int(connected_components(graph, directed=False)[0])


def _merge_on_grid(mesh: Mesh, budget: int) -> Mesh:
    """Merge the vertices in each cell of the finest grid that leaves no more than `budget` of them."""
    position = mesh.vertices - mesh.vertices.min(axis=0)

    def count_at(cell: float) -> int:
        return int(np.count_nonzero(np.bincount(_cells(position, mesh.faces, cell)[1].ravel())))

    cell = finest_cell(float(position.max()), count_at, budget, GRID_STEPS)
    cell_of_vertex, faces = _cells(position, mesh.faces, cell)
    # Each cell is represented by its vertex with the most area around it: the mean would shrink the surface.
    area = np.bincount(mesh.faces.ravel(), np.repeat(face_areas(mesh), 3), len(position))
    order = np.argsort(-area, kind="stable")
    _, first = np.unique(cell_of_vertex[order], return_index=True)
    return repair(Mesh(mesh.vertices[order[first]], faces, mesh.name))


def _cells(position: FloatArray, faces: IntArray, cell: float) -> tuple[Indices, Indices]:
    """Cell of each vertex, numbered without gaps, (n,), and the faces that reach three cells, (k, 3)."""
    _, cell_of_vertex = np.unique(cell_numbers(position, cell), return_inverse=True)
    corners = cell_of_vertex[faces]
    return cell_of_vertex, corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]


def subdivide(mesh: Mesh, floor: int) -> Mesh:
    """Split long edges at their midpoints until there are `floor` vertices.

    Every face of a split edge is split there, and within the old faces, which are flat, edges are flipped to
    make the triangles as even as possible (Delaunay). The surface does not change, point by point, it stays
    connected, and long thin faces become even ones.

    Parameters
    ----------
    mesh : Mesh
        With faces.
    floor : int

    Returns
    -------
    subdivided : Mesh
        The same vertices first. A few more than `floor` where edges of the same length are split together.
    """
    vertices, faces = mesh.vertices, mesh.faces.astype(np.int64)
    parent = np.arange(len(faces))
    while len(vertices) < floor:
        edges, edge_of_side, inner = _edges(faces, parent)
        length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
        length[inner] /= INNER_EDGE
        missing = floor - len(vertices)
        # Not all at once: splitting and flipping leave other edges. Edges of the same length go together, so
        # that the result does not depend on rounding.
        least = np.partition(length, -missing)[-missing] if missing < len(length) else 0.0
        chosen = length >= (1 - 1e-6) * max(least, LEAST_OF_ROUND * length.max())
        vertices, faces, parent = _split(vertices, faces, parent, edges, edge_of_side, chosen)
        faces = _flip(vertices, faces, parent)
    return mesh if len(vertices) == len(mesh.vertices) else Mesh(vertices, faces, mesh.name)


def _edges(faces: Indices, parent: Indices) -> tuple[Indices, Indices, NDArray[np.bool_]]:
    """Find edges (e, 2), those opposite each face's corners (m, 3), and a mask of those in old faces."""
    sides = np.sort(faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    count = int(faces.max()) + 1
    keys, first, edge = np.unique(sides[:, 0] * count + sides[:, 1], return_index=True, return_inverse=True)
    edge = edge.reshape(-1, 3)
    last = np.empty(len(keys), np.int64)
    last[edge.ravel()] = np.arange(edge.size)
    inner = (first != last) & (parent[first // 3] == parent[last // 3])
    return np.stack(np.divmod(keys, count), axis=1), edge, inner


def _split(
    vertices: FloatArray,
    faces: Indices,
    parent: Indices,
    edges: Indices,
    edge_of_side: Indices,
    chosen: NDArray[np.bool_],
) -> tuple[FloatArray, Indices, Indices]:
    """Split the chosen edges and with them all their faces; new faces take the parents of old ones."""
    midpoints = vertices[edges[chosen]].mean(axis=1)
    midpoint_of_edge = np.full(len(edges), -1)
    midpoint_of_edge[chosen] = len(vertices) + np.arange(len(midpoints))
    vertices = np.concatenate([vertices, midpoints])
    midpoint = midpoint_of_edge[edge_of_side]  # opposite each corner; -1: not split
    count = (midpoint >= 0).sum(axis=1)
    new_faces, new_parents = [faces[count == 0]], [parent[count == 0]]

    def add(which: NDArray[np.bool_], *corners: tuple[Indices, Indices, Indices]) -> None:
        new_faces.extend(np.stack(each, axis=1) for each in corners)
        new_parents.extend([parent[which]] * len(corners))

    # One edge split: two faces. Turned so that the split edge lies opposite the first corner.
    a, b, c, ma, _, _ = _turn(faces, midpoint, np.argmax(midpoint >= 0, axis=1), count == 1)
    add(count == 1, (a, b, ma), (a, ma, c))
    # Two: a corner, and the rest along one of its diagonals. Opposite the first corner: the whole edge.
    whole = np.argmax(midpoint < 0, axis=1)
    a, b, c, _, mb, mc = _turn(faces, midpoint, whole, count == 2)
    add(count == 2, (a, mc, mb), (mc, b, mb), (b, c, mb))
    # Three: four faces.
    a, b, c, ma, mb, mc = _turn(faces, midpoint, whole, count == 3)
    add(count == 3, (a, mc, mb), (mc, b, ma), (mb, ma, c), (ma, mb, mc))
    return vertices, np.concatenate(new_faces), np.concatenate(new_parents)


def _turn(faces: Indices, midpoint: Indices, first: Indices, which: NDArray[np.bool_]) -> Indices:
    """Corners of some faces and the midpoints opposite, (6, k), turned so that corner `first` comes first."""
    rows = np.flatnonzero(which)[:, None]
    order = (first[rows] + np.arange(3)) % 3
    return np.concatenate([faces[rows, order], midpoint[rows, order]], axis=1).T


def _flip(vertices: FloatArray, faces: Indices, parent: Indices) -> Indices:
    """Flip edges inside old faces until every triangle is Delaunay in its plane (Lawson 1977)."""
    faces = faces.copy()
    for _ in range(MOST_FLIP_ROUNDS):
        _, edge_of_side, inner = _edges(faces, parent)
        order = np.argsort(edge_of_side.ravel(), kind="stable")
        order = order[inner[edge_of_side.ravel()[order]]]
        one, other = order[0::2], order[1::2]  # the two sides of each inner edge
        cotangents = _opposite_cotangents(vertices, faces)
        total = cotangents.ravel()[one] + cotangents.ravel()[other]
        # Each face takes part in its most urgent flip only, and only if its neighbour's is the same.
        urgent = np.flatnonzero(total < -FLIP_TOLERANCE)
        urgent = urgent[np.argsort(total[urgent], kind="stable")]
        if len(urgent) == 0:
            break
        best = np.full(len(faces), len(urgent))
        rank = np.arange(len(urgent))
        np.minimum.at(best, one[urgent] // 3, rank)
        np.minimum.at(best, other[urgent] // 3, rank)
        agreed = (best[one[urgent] // 3] == rank) & (best[other[urgent] // 3] == rank)
        one, other = one[urgent[agreed]], other[urgent[agreed]]
        p, i, j = (faces[one // 3, (one % 3 + step) % 3] for step in range(3))
        q = faces[other // 3, other % 3]
        faces[one // 3] = np.stack([p, i, q], axis=1)
        faces[other // 3] = np.stack([q, j, p], axis=1)
    return faces


def _opposite_cotangents(vertices: FloatArray, faces: Indices) -> FloatArray:
    """Cotangent of the angle at each corner, (m, 3)."""
    corners = vertices[faces]
    to_next = np.roll(corners, -1, axis=1) - corners
    to_last = np.roll(corners, 1, axis=1) - corners
    double_area = np.linalg.norm(np.cross(to_next[:, 0], to_last[:, 0]), axis=1)
    # A face without area has the cotangents of a very low one.
    longest = np.linalg.norm(to_next, axis=2).max(axis=1)
    cotangents: FloatArray = (to_next * to_last).sum(axis=2) / np.maximum(double_area, 1e-12 * longest**2)[
        :, None
    ]
    return cotangents


def thin(points: FloatArray, count: int) -> FloatArray:
    """Thin points to `count` at most, about equally dense everywhere: the mean in each cell of a grid.

    The grid is about the finest one that leaves no more. Means have less noise than the points.

    Parameters
    ----------
    points : (n, 3) array
    count : int
        Most points.

    Returns
    -------
    thinned : (m, 3) array
        m ≤ count. The array itself if it has no more points.
    """
    if len(points) <= count:
        return points
    position = points - points.min(axis=0)
    cell = finest_cell(
        float(position.max()),
        lambda cell: len(np.unique(cell_numbers(position, cell))),
        count,
        THINNING_STEPS,
    )
    _, group, sizes = np.unique(cell_numbers(position, cell), return_inverse=True, return_counts=True)
    return np.stack([np.bincount(group, axis) / sizes for axis in points.T], axis=1)


def cell_numbers(position: FloatArray, cell: float) -> NDArray[np.int64]:
    """Give the cells of points in a grid that begins at 0 a number each.

    Parameters
    ----------
    position : (n, 3) array
        Not negative, and less than a million cells in each direction.
    cell : float
        Side of a cell.

    Returns
    -------
    numbers : (n,) array of int
        Equal for points in one cell.
    """
    x, y, z = (position / cell).astype(np.int64).T
    return np.asarray((x * CELLS_PER_SIDE + y) * CELLS_PER_SIDE + z)


def finest_cell(longest_side: float, count_at: Callable[[float], int], budget: int, steps: int) -> float:
    """Find about the smallest cells of which no more than a budget are occupied, by bisection.

    Parameters
    ----------
    longest_side : float
        Largest coordinate.
    count_at : callable
        Number of occupied cells by the side of a cell.
    budget : int
        Most occupied cells.
    steps : int
        Number of bisections: the side is found to 2^(1 - steps) of the longest one.

    Returns
    -------
    cell : float
        Side of a cell.
    """
    too_small, cell = 0.0, 2 * longest_side  # the larger holds everything
    for _ in range(steps):
        middle = (too_small + cell) / 2
        if count_at(middle) <= budget:
            cell = middle
        else:
            too_small = middle
    return cell
