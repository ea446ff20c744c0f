# SPDX-License-Identifier: MIT
"""Flat regions: neighbouring faces in one plane, however it is cut into triangles."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.mesh.measures import box_sides, cross_products, dots
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.preprocessing.triangulation import EdgeTable, Indices, edge_table

__all__ = ["flat_regions", "height_tolerance"]

# Height over a plane, as a share of the bounding-box diagonal, that counts as none: what is left of a flat
# region after it was moved and stored in float32, and less than anyone models.
FLATNESS = 1e-5

LEAST_COSINE = 0.9  # between the normals of neighbours: a low face may be turned by rounding


def height_tolerance(vertices: FloatArray) -> float:
    """Compute the height over a plane that counts as none.

    Parameters
    ----------
    vertices : (n, 3) array
        Of the whole mesh.

    Returns
    -------
    tolerance : float
    """
    return FLATNESS * float(np.linalg.norm(box_sides(vertices)))


def flat_regions(mesh: Mesh, edges: EdgeTable | None = None) -> Indices:
    """Find the flat regions of a surface.

    Parameters
    ----------
    mesh : Mesh
        Repaired.
    edges : EdgeTable, optional
        Those of its faces, if they are known.

    Returns
    -------
    region : (m,) array of int
        Region of each face, from 0. Faces of a region are connected by edges between exactly two of them
        and lie in one plane. Where a fine curved surface is flat from face to face, but not as a whole,
        every face is a region.
    """
    vertices, faces = mesh.vertices, mesh.faces.astype(np.int64)
    tolerance = height_tolerance(vertices)
    edges = edges or edge_table(faces)
    a, b, c = vertices[faces.T]
    product = cross_products(b - a, c - a).T
    double_area = np.sqrt(dots(product, product))
    normal = product / np.maximum(double_area, np.finfo(float).tiny)[:, None]

    one, other = edges.first[edges.between_two], edges.last[edges.between_two]
    swap = double_area[one // 3] < double_area[other // 3]
    larger, smaller = np.where(swap, other, one) // 3, np.where(swap, one, other)
    height = dots(vertices[faces.ravel()[smaller]] - a[larger], normal[larger])
    flat = (np.abs(height) <= tolerance) & (dots(normal[larger], normal[smaller // 3]) > LEAST_COSINE)
    graph = coo_array(
        (np.ones(np.count_nonzero(flat), np.int8), (larger[flat], smaller[flat] // 3)),
        shape=(len(faces),) * 2,
    )
    count, label = connected_components(graph, directed=False)
    region = label.astype(np.int64)
    if count == len(faces):
        return np.arange(len(faces))

    # Flat from face to face, and also as a whole? A single face is.
    several = np.flatnonzero(np.bincount(region)[region] > 1)
    own, own_area = region[several], double_area[several]
    a, b, c = (corner[several] for corner in (a, b, c))
    weight = np.maximum(np.bincount(own, own_area, count), np.finfo(float).tiny)
    plane_normal = _sums(own, own_area, normal[several], count)
    plane_normal /= np.maximum(np.linalg.norm(plane_normal, axis=1), np.finfo(float).tiny)[:, None]
    origin = _sums(own, own_area, (a + b + c) / 3, count) / weight[:, None]
    bend = np.zeros(count)
    for corner in (a, b, c):
        np.maximum.at(bend, own, np.abs(dots(corner - origin[own], plane_normal[own])))
    bent = several[bend[own] > 2 * tolerance]
    region[bent] = count + bent
    return np.unique(region, return_inverse=True)[1]


def _sums(region: Indices, weight: FloatArray, vectors: FloatArray, count: int) -> FloatArray:
    """Weighted sums of the vectors of each region."""
    return np.stack([np.bincount(region, weight * x, count).astype(np.float64) for x in vectors.T], axis=1)
