# SPDX-License-Identifier: MIT
"""Resampling: every surface and every point cloud gets a working resolution."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.mesh.connectivity import boundary_vertices
from shapegoogle_core.mesh.measures import bounding_box, face_areas
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh
from shapegoogle_core.preprocessing.coarsening import coarsen
from shapegoogle_core.preprocessing.repair import repair
from shapegoogle_core.preprocessing.subdivision import subdivide
from shapegoogle_core.preprocessing.triangulation import Indices

__all__ = ["cell_numbers", "finest_cell", "resample", "simplify", "thin"]

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


def resample(mesh: Mesh, floor: int = 1000, budget: int = 5000, longest_edge: float = 0.0) -> Mesh:
    """Subdivide a mesh below the floor of vertices, simplify one above the budget.

    Parameters
    ----------
    mesh : Mesh
        Repaired. A point cloud is only thinned to the budget; see `thin`.
    floor : int, optional
        Fewest vertices wanted; see `subdivide`.
    budget : int, optional
        Most vertices; see `simplify`.
    longest_edge : float, optional
        If positive, the vertices that the surface does not need are removed first (see `coarsen`), and edges
        longer than this share of √area are split while the budget allows it.

    Returns
    -------
    resampled : Mesh
        With `budget` vertices at most.
    """
    if mesh.is_point_cloud:
        return Mesh(thin(mesh.vertices, budget), name=mesh.name)
    if longest_edge > 0:
        return _resample_evenly(mesh, floor, budget, longest_edge)
    if len(mesh.vertices) < floor:
        mesh = subdivide(mesh, floor)
    if len(mesh.vertices) > budget:
        mesh = simplify(mesh, budget)
    return mesh


def _resample_evenly(mesh: Mesh, floor: int, budget: int, longest_edge: float) -> Mesh:
    """Simplify, coarsen and subdivide a mesh; see `resample`."""
    longest = longest_edge * float(np.sqrt(mesh.area))
    if len(mesh.vertices) > budget:
        mesh = simplify(mesh, budget)
    coarse, region = coarsen(mesh)
    split = partial(subdivide, floor=min(floor, budget), longest=longest, enough=budget // 2)
    fine = split(coarse, most=2 * budget, region=region)
    surplus = len(fine.vertices) - budget
    if surplus <= 0:
        return fine
    room = max(len(coarse.vertices) - surplus, budget // 2)
    if room < len(coarse.vertices):  # long edges are split at the cost of detail
        coarse, region = coarsen(simplify(coarse, room))
    return split(coarse, most=budget, region=region)


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
        Repaired, with `budget` vertices at most; the same mesh if it has no more.
    """
    if len(mesh.vertices) <= budget:
        return mesh
    # A collapse keeps all vertices on boundaries: with so many of them its end is known.
    if np.count_nonzero(boundary_vertices(mesh)) > FAR_ABOVE_BUDGET * budget:
        return _merge_on_grid(mesh, budget)
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
    origin, end = bounding_box(mesh.vertices)
    unit = np.linalg.norm(end - origin) / COLLAPSED_DIAGONAL
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
    position = mesh.vertices - bounding_box(mesh.vertices)[0]

    def count_at(cell: float) -> int:
        return int(np.count_nonzero(np.bincount(_cells(position, mesh.faces, cell)[1].ravel())))

    cell = finest_cell(float(position.max()), count_at, budget, GRID_STEPS)
    cell_of_vertex, faces = _cells(position, mesh.faces, cell)
    if len(faces) == 0:  # all leaves are smaller than the cells: what remains are points
        return Mesh(thin(mesh.vertices, budget), faces, mesh.name)
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
    position = points - bounding_box(points)[0]
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
