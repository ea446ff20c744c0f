# SPDX-License-Identifier: MIT
"""The output of every reader: vertices and polygons; and the one place where polygons become triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import check_face_count
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Polygons", "triangulate"]


@dataclass(frozen=True)
class Polygons:
    """Vertices and faces as they are in a file.

    Parameters
    ----------
    vertices : (n, 3) array of float64
    corners : (c,) array of int
        Vertices of all polygons, one polygon after the other, counted from 0.
    sizes : (p,) array of int
        Number of corners of each polygon; their sum is c. Empty for points alone.
    """

    vertices: FloatArray
    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]

    @classmethod
    def from_triangles(cls, vertices: FloatArray, faces: NDArray[np.int64]) -> Polygons:
        """Take triangles, an (m, 3) array."""
        return cls(vertices, faces.ravel(), np.full(len(faces), 3))

    @classmethod
    def from_points(cls, vertices: FloatArray) -> Polygons:
        """Take points without faces."""
        return cls(vertices, np.empty(0, np.int64), np.empty(0, np.int64))


def triangulate(polygons: Polygons, max_faces: int) -> NDArray[np.int64]:
    """Cut polygons into fans of triangles.

    Parameters
    ----------
    polygons : Polygons
        Polygons of fewer than three corners are points and lines, and give nothing.
    max_faces : int
        Largest number of triangles.

    Returns
    -------
    triangles : (m, 3) array of int
        In the order of the polygons. If all of them are quads, the first triangles of all come before the
        second ones: simplification depends on the order, and the shipped models were made with this one.

    Raises
    ------
    FormatError
        If there are more triangles than `max_faces`.
    """
    corners, sizes = polygons.corners, polygons.sizes
    counts = np.maximum(sizes - 2, 0)
    check_face_count(int(counts.sum()), max_faces)
    if len(sizes) and (sizes == sizes[0]).all() and sizes[0] in (3, 4):
        rows = corners.reshape(len(sizes), -1)
        return rows if sizes[0] == 3 else np.concatenate([rows[:, [0, 1, 2]], rows[:, [2, 3, 0]]])
    starts, places = np.cumsum(sizes) - sizes, np.cumsum(counts) - counts
    triangles = np.empty((int(counts.sum()), 3), np.int64)
    for size in np.unique(sizes[sizes > 2]).tolist():
        fan = np.array([[0, corner, corner + 1] for corner in range(1, size - 1)])
        if size == 4:
            fan[1] = 2, 3, 0
        chosen = sizes == size
        rows = corners[starts[chosen, None] + np.arange(size)]
        triangles[places[chosen, None] + np.arange(size - 2)] = rows[:, fan]
    return triangles
