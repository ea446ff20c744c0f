# SPDX-License-Identifier: MIT
"""Figures of a surface that do not depend on how a reader stores it: area, extent, counts after welding."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

__all__ = ["Facts", "differences", "measure", "triangles_of_polygons"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Vertices nearer than this, relative to the largest coordinate, are one: Blender keeps seven digits. But none
# are that are farther apart than this share of the extent.
WELD, FARTHEST = 2e-6, 1e-4
# Relative differences above which two readers disagree.
SAME_AREA, SAME_PLACE, SAME_COUNT = 1e-3, 1e-4, 1e-3


@dataclass(frozen=True)
class Facts:
    """Figures of what a reader read.

    Attributes
    ----------
    vertices : int
        Number of different places of corners of faces; of points, if there are no faces.
    faces : int
        Number of different triangles with three different corners.
    area : float
    lower, upper : (float, float, float)
        Corners of the bounding box of the faces; of the points, if there are no faces.
    """

    vertices: int
    faces: int
    area: float
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]


def measure(vertices: FloatArray, faces: IntArray, area: float | None = None) -> Facts | None:
    """Measure a mesh or a point cloud.

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array
    area : float, optional
        If it is known better than from the triangles.

    Returns
    -------
    facts : Facts or None
        None if there is nothing, or a coordinate is not finite.
    """
    vertices, faces = np.asarray(vertices, np.float64), np.asarray(faces, np.int64).reshape(-1, 3)
    if len(faces):
        used, corners = np.unique(faces, return_inverse=True)
        vertices, faces = vertices[used], corners.reshape(-1, 3)
    if not len(vertices) or not np.isfinite(vertices).all():
        return None
    lower, upper = vertices.min(axis=0), vertices.max(axis=0)
    if area is None:
        a, b, c = vertices[faces].transpose(1, 0, 2)
        area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
    if not len(faces):
        count = len(np.unique(vertices.astype(np.float32), axis=0))
        return Facts(count, 0, 0.0, _triple(lower), _triple(upper))
    welded = _weld(vertices)
    triangles = np.sort(welded[faces], axis=1)
    whole = (triangles[:, 0] < triangles[:, 1]) & (triangles[:, 1] < triangles[:, 2])
    different = np.unique(triangles[whole], axis=0)
    return Facts(int(welded.max()) + 1, len(different), area, _triple(lower), _triple(upper))


def differences(one: Facts, other: Facts) -> dict[str, float]:
    """Compare the figures of two readers.

    Parameters
    ----------
    one, other : Facts

    Returns
    -------
    differences : dict of str to float
        Of the figures "area", "extent", "vertices" and "faces" that differ: the relative difference.
    """
    ends = np.array([[one.lower, one.upper], [other.lower, other.upper]])
    size = max(float(np.abs(ends).max()), 1e-300)
    found = {
        "area": (_relative(one.area, other.area), SAME_AREA),
        "extent": (float(np.abs(ends[0] - ends[1]).max()) / size, SAME_PLACE),
        "vertices": (_relative(one.vertices, other.vertices), SAME_COUNT),
        "faces": (_relative(one.faces, other.faces), SAME_COUNT),
    }
    return {figure: difference for figure, (difference, same) in found.items() if not difference <= same}


def triangles_of_polygons(vertices: FloatArray, polygons: IntArray) -> tuple[IntArray, float]:
    """Cut polygons with the same number of corners into fans, and measure their area without the fans.

    Parameters
    ----------
    vertices : (n, 3) array
    polygons : (m, k) array

    Returns
    -------
    triangles : (m (k - 2), 3) array
    area : float
        That of a quad along the diagonal that lies inside it. That of polygons with more corners by the
        surveyor's formula, which is right for flat ones, concave or not.
    """
    places = np.arange(1, polygons.shape[1] - 1)
    fans = np.stack([np.zeros_like(places), places, places + 1], axis=1)
    triangles = polygons[:, fans].reshape(-1, 3)
    corners = vertices[polygons] - vertices[polygons[:, :1]]
    normals = np.cross(corners, np.roll(corners, -1, axis=1)) / 2
    if polygons.shape[1] != 4:
        return triangles, float(np.linalg.norm(normals.sum(axis=1), axis=1).sum())
    first, second = normals[:, 1], normals[:, 2]
    fits = np.einsum("ni,ni->n", first, second) >= 0
    other = np.cross(corners[:, 1] - corners[:, 3], -corners[:, 3]) / 2
    across = np.cross(corners[:, 2] - corners[:, 1], corners[:, 3] - corners[:, 1]) / 2
    lengths = [np.linalg.norm(normal, axis=1) for normal in (first, second, other, across)]
    return triangles, float(np.where(fits, lengths[0] + lengths[1], lengths[2] + lengths[3]).sum())


def _weld(vertices: FloatArray) -> IntArray:
    """Give vertices at the same place the same number, from 0."""
    largest, extent = float(np.abs(vertices).max()), float(np.ptp(vertices, axis=0).max())
    distance = max(min(WELD * largest, FARTHEST * extent), 1e-300)
    places, first = np.unique(vertices, axis=0, return_inverse=True)
    pairs = KDTree(places).query_pairs(distance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), np.int8), tuple(pairs.T)), shape=(len(places),) * 2)
    labels = connected_components(links, directed=False)[1].astype(np.int64)
    return np.asarray(labels[first.ravel()])


def _relative(one: float, other: float) -> float:
    largest = max(abs(one), abs(other))
    return abs(one - other) / largest if largest else 0.0


def _triple(values: FloatArray) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
