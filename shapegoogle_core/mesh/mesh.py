# SPDX-License-Identifier: MIT
"""The `Mesh` value that everything starts from."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.errors import MeshError

__all__ = ["Mesh", "face_areas", "unique_edges", "vertex_areas", "vertex_normals"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True, eq=False, init=False)
class Mesh:
    """A triangle mesh, or a point cloud when it has no faces.

    Parameters
    ----------
    vertices : (n, 3) array_like of float
        Positions in the unit of the file. Stored as float64.
    faces : (m, 3) array_like of int, optional
        Indices of each triangle's corners. Stored as int32. Left out: a point cloud.
    name : str, optional
        What errors about this mesh call it: a file or object name.

    Raises
    ------
    MeshError
        If an array has the wrong shape, a coordinate is not finite or a face index is out of range.
    """

    vertices: FloatArray
    faces: IntArray = field(default_factory=lambda: np.empty((0, 3), np.int32))
    name: str = "mesh"

    def __init__(self, vertices: ArrayLike, faces: ArrayLike | None = None, name: str = "mesh") -> None:
        try:
            points = np.array(vertices, dtype=np.float64, order="C")
            corners = np.empty((0, 3), np.int64) if faces is None else np.asarray(faces)
        except (TypeError, ValueError) as error:
            raise MeshError(f"{name!r}: vertices and faces must be arrays of numbers ({error})") from error
        if corners.size == 0:
            corners = np.empty((0, 3), np.int64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise MeshError(f"{name!r}: vertices must have shape (n, 3), not {points.shape}")
        if corners.ndim != 2 or corners.shape[1] != 3:
            raise MeshError(f"{name!r}: faces must be triangles, shape (m, 3), not {corners.shape}")
        if corners.dtype.kind not in "iu":
            raise MeshError(f"{name!r}: faces must be integers, not {corners.dtype}")
        bad = ~np.isfinite(points).all(axis=1)
        if bad.any():
            raise MeshError(
                f"{name!r}: {int(bad.sum())} of {len(points)} vertices have NaN or infinite coordinates "
                f"(first: vertex {int(bad.argmax())}); repair or export the mesh again"
            )
        out_of_range = corners[(corners < 0) | (corners >= len(points))]
        if out_of_range.size:
            raise MeshError(
                f"{name!r}: a face names vertex {int(out_of_range[0])}, but there are only {len(points)} "
                "vertices (counted from 0); the file is damaged or was cut short"
            )
        indices = corners.astype(np.int32)
        points.setflags(write=False)
        indices.setflags(write=False)
        object.__setattr__(self, "vertices", points)
        object.__setattr__(self, "faces", indices)
        object.__setattr__(self, "name", name)

    @property
    def area(self) -> float:
        """Surface area in squared units of the vertices; 0 for a point cloud."""
        return float(face_areas(self).sum())

    @property
    def is_point_cloud(self) -> bool:
        """Whether there are no faces."""
        return len(self.faces) == 0

    def __repr__(self) -> str:
        return f"Mesh({self.name!r}, {len(self.vertices)} vertices, {len(self.faces)} faces)"


def face_areas(mesh: Mesh) -> FloatArray:
    """Area of each face.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    areas : (m,) array
        In squared units of the vertices.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    areas: FloatArray = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return areas


def vertex_areas(mesh: Mesh) -> FloatArray:
    """Area of each vertex: a third of that of its faces.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    areas : (n,) array
        In squared units of the vertices; their sum is the area of the mesh.
    """
    shares = np.repeat(face_areas(mesh) / 3, 3)
    return np.asarray(np.bincount(mesh.faces.ravel(), shares, len(mesh.vertices)), np.float64)


def vertex_normals(mesh: Mesh) -> FloatArray:
    """Take the mean of the normals of each vertex's faces, by area.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    normals : (n, 3) array
        Of unit length; 0 where the faces cancel each other out, and at vertices without faces.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    weighted = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    corners = mesh.faces.ravel()
    summed = np.stack([np.bincount(corners, axis, len(mesh.vertices)) for axis in weighted.T], axis=1)
    lengths = np.linalg.norm(summed, axis=1, keepdims=True)
    normals: FloatArray = summed / np.maximum(lengths, np.finfo(float).tiny)
    return normals


def unique_edges(mesh: Mesh) -> tuple[IntArray, NDArray[np.int64]]:
    """Undirected edges and how many faces use each.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    edges : (e, 2) array of int32
        Each edge once, smaller vertex first, sorted.
    face_counts : (e,) array of int
        1 on an open boundary, 2 inside a manifold surface, more on a non-manifold edge.
    """
    start, end = mesh.faces.ravel(), mesh.faces[:, [1, 2, 0]].ravel()
    # One integer per edge sorts ten times faster than rows do.
    keys = np.minimum(start, end).astype(np.int64) * len(mesh.vertices) + np.maximum(start, end)
    unique_keys, face_counts = np.unique(keys, return_counts=True)
    edges = np.stack(np.divmod(unique_keys, max(len(mesh.vertices), 1)), axis=1).astype(np.int32)
    return edges, face_counts
