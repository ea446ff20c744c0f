# SPDX-License-Identifier: MIT
"""Skin of a skeleton: a smooth union of round cones, meshed by marching cubes."""

from __future__ import annotations

import importlib

import fast_simplification
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from benchmarks.creatures.skeleton import RoundCone, Skeleton
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, unique_edges

__all__ = ["cone_distances", "is_closed_manifold", "skin_mesh"]

FloatArray = NDArray[np.float64]

# Number of blend widths beyond which a part does not affect the union: exp(-5) < 0.01.
_REACH = 5.0
_MAX_CELLS = 1_200_000
# Mean number of vertices of marching cubes on a square of one grid cell.
_VERTICES_PER_SQUARE_CELL = 1.4
# Least distance of a vertex from a grid point, in cells.
_LEAST_SHARE = 0.06


def cone_distances(cone: RoundCone, points: tuple[FloatArray, FloatArray, FloatArray]) -> FloatArray:
    """Compute the signed distance to a round cone, negative inside; a lower bound if it is stretched.

    Parameters
    ----------
    cone : RoundCone
    points : three arrays that broadcast together
        x, y and z. One-dimensional axes of a grid are fast.

    Returns
    -------
    distances : array of the broadcast shape
    """
    start = cone.start / cone.stretch
    axis = cone.end / cone.stretch - start
    length_squared = float(axis @ axis)
    x, y, z = (
        coordinate / factor - origin
        for coordinate, factor, origin in zip(points, cone.stretch, start, strict=True)
    )
    squared = x * x + y * y + z * z
    scale = float(cone.stretch.min())
    distances: FloatArray
    if length_squared == 0:
        distances = (np.sqrt(squared) - cone.start_radius) * scale
        return distances
    along = np.clip((x * axis[0] + y * axis[1] + z * axis[2]) / length_squared, 0, 1)
    squared = (x - along * axis[0]) ** 2 + (y - along * axis[1]) ** 2 + (z - along * axis[2]) ** 2
    radius = cone.start_radius + along * (cone.end_radius - cone.start_radius)
    distances = (np.sqrt(squared) - radius) * scale
    return distances


def _cone_bounds(cone: RoundCone, margin: float) -> tuple[FloatArray, FloatArray]:
    radius = max(cone.start_radius, cone.end_radius) + margin / cone.stretch.min()
    return (
        np.minimum(cone.start, cone.end) - radius * cone.stretch,
        np.maximum(cone.start, cone.end) + radius * cone.stretch,
    )


def _sample_union(skeleton: Skeleton, cell: float) -> tuple[FloatArray, FloatArray]:
    """Sample the union's level function on a grid: log Σ_g exp(−d_g / k_g), positive inside.

    Returns the values and the position of the first grid point.
    """
    # Where parts meet, the union extends by up to two blend widths.
    margin = 3 * cell + 2 * max(skeleton.blends)
    solid = [_cone_bounds(cone, margin) for cone in skeleton.cones]
    lower = np.min([bounds[0] for bounds in solid], axis=0)
    upper = np.max([bounds[1] for bounds in solid], axis=0)
    shape = np.ceil((upper - lower) / cell).astype(int) + 1
    axes = [lower[axis] + cell * np.arange(shape[axis]) for axis in range(3)]
    total = np.full(shape, np.exp(-2 * _REACH))

    def window(low: FloatArray, high: FloatArray) -> tuple[slice, slice, slice]:
        first = np.clip(np.floor((low - lower) / cell).astype(int), 0, shape)
        last = np.clip(np.ceil((high - lower) / cell).astype(int) + 1, 0, shape)
        return tuple(slice(a, b) for a, b in zip(first, last, strict=True))  # type: ignore[return-value]

    for group in range(len(skeleton.blends)):
        cones = [cone for cone in skeleton.cones if cone.group == group]
        blend = max(skeleton.blends[group], 0.25 * cell)
        bounds = [_cone_bounds(cone, _REACH * blend) for cone in cones]
        outer = window(
            np.min([low for low, _ in bounds], axis=0), np.max([high for _, high in bounds], axis=0)
        )
        nearest = np.full([part.stop - part.start for part in outer], np.inf)
        for cone, (low, high) in zip(cones, bounds, strict=True):
            inner = window(low, high)
            grid = np.ix_(*(axes[axis][inner[axis]] for axis in range(3)))
            local = tuple(
                slice(part.start - base.start, part.stop - base.start)
                for part, base in zip(inner, outer, strict=True)
            )
            np.minimum(nearest[local], cone_distances(cone, grid), out=nearest[local])
        total[outer] += np.exp(np.clip(-nearest / blend, -3 * _REACH, 3 * _REACH))
    return np.log(total), lower


def _largest_component(vertices: FloatArray, faces: NDArray[np.int32]) -> Mesh:
    links = coo_array((np.ones(len(faces)), (faces[:, 0], faces[:, 1])), shape=(len(vertices),) * 2)
    links = links + coo_array((np.ones(len(faces)), (faces[:, 1], faces[:, 2])), shape=(len(vertices),) * 2)
    _, labels = connected_components(links, directed=False)
    kept = labels == np.bincount(labels[faces[:, 0]]).argmax()
    renumbered = np.cumsum(kept) - 1
    return Mesh(vertices[kept], renumbered[faces[kept[faces[:, 0]]]])


def is_closed_manifold(mesh: Mesh) -> bool:
    """Return whether every edge joins two faces and the faces around every vertex form one fan.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    closed : bool
    """
    _, face_counts = unique_edges(mesh)
    if not (face_counts == 2).all():
        return False
    # One fan per vertex: the corners opposite each vertex form a single cycle. Count cycles by joining the
    # two corners of every face that meet across an edge at the same vertex.
    corner = np.arange(mesh.faces.size).reshape(-1, 3)
    ends = mesh.faces[:, [0, 1, 2]], mesh.faces[:, [1, 2, 0]]
    key = np.minimum(*ends).astype(np.int64) * len(mesh.vertices) + np.maximum(*ends)
    order = np.argsort(key.ravel(), kind="stable").reshape(-1, 2)
    face, slot = np.divmod(order, 3)
    links = []
    for left in (slot[:, 0], (slot[:, 0] + 1) % 3):
        vertex = mesh.faces[face[:, 0], left]
        right = np.where(mesh.faces[face[:, 1], slot[:, 1]] == vertex, slot[:, 1], (slot[:, 1] + 1) % 3)
        links.append(np.stack([corner[face[:, 0], left], corner[face[:, 1], right]]))
    rows, columns = np.concatenate(links, axis=1)
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(corner.size,) * 2)
    fans, _ = connected_components(graph, directed=False)
    used = len(np.unique(mesh.faces))
    return bool(fans == used == len(mesh.vertices))


def _march(skeleton: Skeleton, cell: float) -> Mesh:
    try:
        marching_cubes = importlib.import_module("skimage.measure").marching_cubes
    except ImportError as error:
        raise ImportError(
            "making creatures needs scikit-image, which the optional extra 'demo' brings: "
            "pip install 'shapegoogle-core[demo]'"
        ) from error
    values, origin = _sample_union(skeleton, cell)
    vertices, faces, _, _ = marching_cubes(values, 0.0, gradient_direction="ascent")
    # Every vertex lies on a grid edge; near grid points several would nearly coincide.
    below = np.floor(vertices)
    share = vertices - below
    vertices = below + np.where(share > 0, np.clip(share, _LEAST_SHARE, 1 - _LEAST_SHARE), 0)
    return _largest_component(origin + cell * vertices.astype(np.float64), faces)


def skin_mesh(skeleton: Skeleton, vertex_count: int) -> Mesh | None:
    """Make a closed manifold triangle mesh around a skeleton in its rest pose.

    Parameters
    ----------
    skeleton : Skeleton
    vertex_count : int
        Number of vertices, met within 1 %.

    Returns
    -------
    mesh : Mesh or None
        None if no closed manifold with this number of vertices was found.

    Raises
    ------
    MeshError
        If the finest grid gives fewer vertices.
    ImportError
        If scikit-image is not installed.
    """
    bounds = [_cone_bounds(cone, 0) for cone in skeleton.cones]
    size = np.max([high for _, high in bounds], axis=0) - np.min([low for low, _ in bounds], axis=0)
    coarsest = float(np.cbrt(size.prod() / _MAX_CELLS))
    cell = max(0.9 * min(cone.thickness for cone in skeleton.cones), coarsest)
    # A collapse may pinch the surface; another grid changes the order of collapses.
    for factor in (1.0, 0.96, 0.92, 0.88):
        mesh = _march(skeleton, factor * cell)
        if len(mesh.vertices) < 1.3 * vertex_count:
            finer = float(np.sqrt(mesh.area * _VERTICES_PER_SQUARE_CELL / (1.6 * vertex_count)))
            mesh = _march(skeleton, factor * max(finer, coarsest))
            if len(mesh.vertices) < vertex_count:
                raise MeshError(
                    f"this creature can have at most about {len(mesh.vertices)} vertices, not {vertex_count}"
                )
        simplified = _simplify(mesh, vertex_count)
        if simplified is not None:
            return simplified
    return None


def _simplify(mesh: Mesh, vertex_count: int) -> Mesh | None:
    """Collapse edges down to a number of vertices; None if the result is not a closed manifold."""
    # Number of faces for this number of vertices by Euler's formula.
    faces_wanted = len(mesh.faces) - 2 * (len(mesh.vertices) - vertex_count)
    # The lowest aggressiveness makes the best triangles, but rarely pinches the surface where others do not.
    for aggressiveness in (3, 5, 7):
        points, faces = fast_simplification.simplify(
            mesh.vertices.copy(), mesh.faces.copy(), target_count=faces_wanted, agg=aggressiveness
        )
        simplified = _largest_component(points.astype(np.float64), faces)
        met = abs(len(simplified.vertices) - vertex_count) <= 0.01 * vertex_count
        if met and is_closed_manifold(simplified) and _has_no_slivers(simplified):
            return simplified
    return None


def _has_no_slivers(mesh: Mesh) -> bool:
    """Return whether no edge is degenerate."""
    edges, _ = unique_edges(mesh)
    lengths = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    return bool(lengths.min() > 1e-3 * lengths.mean())
