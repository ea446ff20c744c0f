# SPDX-License-Identifier: MIT
"""Mesh HOG, histograms of the gradient of a function on the surface (paper, section 3.2)."""

from __future__ import annotations

import math

import numpy as np

from shapegoogle_core.descriptors.checks import check_bins, check_radius
from shapegoogle_core.descriptors.geodesics import geodesic_neighbors
from shapegoogle_core.laplacian import cotangent, heat_step
from shapegoogle_core.mesh import MeshLike, clean_surface
from shapegoogle_core.mesh.connectivity import boundary_vertices
from shapegoogle_core.mesh.measures import vertex_areas, vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["mean_curvature", "mesh_hog", "vertex_gradients"]


def mean_curvature(mesh: Mesh, smoothing: float = 3e-3) -> FloatArray:
    """Mean curvature of every vertex, smoothed and without its sign.

    The Laplacian of the positions is twice the mean curvature along the normal, Δx = -2 H n. An implicit step
    of heat flow removes the noise that two derivatives amplify: |H| = ½ ‖(A + tW)⁻¹ W x‖, with the cotangent
    stiffness W, the areas A and the time t of the step. On an open boundary W x is set to 0. If the sign
    matters, use `keypoints.scale_space.signed_mean_curvature`.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.
    smoothing : float
        t as a share of the area: waves shorter than 2π √(t · area) lose more than half of their amplitude.

    Returns
    -------
    curvature : (n,) array
        ≥ 0, in 1 / mesh units.

    Raises
    ------
    ValueError
        If the smoothing is negative.
    """
    if not 0 <= smoothing < math.inf:
        raise ValueError(f"smoothing must be a share of the area ≥ 0, not {smoothing}")
    operator = cotangent(mesh)
    bending = operator.stiffness @ mesh.vertices
    # There W x is the pull of the rim, however flat the surface is.
    bending[boundary_vertices(mesh)] = 0
    factor = heat_step(operator, smoothing * operator.lumped_mass.sum())
    return np.asarray(0.5 * np.linalg.norm(factor.solve(bending), axis=1))


def vertex_gradients(mesh: Mesh, values: FloatArray) -> FloatArray:
    """Gradient of a function along the surface, at every vertex: the mean over its faces, weighted by area.

    On a face with unit normal n and area a the gradient is Σ_k f_k n × e_k / 2a, where e_k is the side
    opposite to corner k.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.
    values : (n,) array
        f, the function at the vertices.

    Returns
    -------
    gradients : (n, 3) array
        In the unit of f / mesh units.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    f = values[mesh.faces]
    turned = np.cross(normals, f[:, :1] * (c - b) + f[:, 1:2] * (a - c) + f[:, 2:] * (b - a)) / 2
    corners, weighted = mesh.faces.ravel(), np.repeat(turned / 3, 3, axis=0)
    summed = np.stack([np.bincount(corners, axis, len(values)) for axis in weighted.T], axis=1)
    return summed / np.maximum(vertex_areas(mesh), np.finfo(float).tiny)[:, None]


def mesh_hog(
    mesh: MeshLike,
    radius: float = 0.2,
    sectors: int = 4,
    orientations: int = 8,
    smoothing: float = 3e-3,
    floor: float = 10.0,
) -> FloatArray:
    """Mesh HOG of every vertex, of the mean curvature (paper, section 3.2; Zaharescu et al. 2009).

    The gradients of the mean curvature around x are projected to the tangent plane at x, whose first axis is
    their mean. Their lengths, with a Gaussian weight of the distance, are summed by the sector of the plane
    in which they lie and by their orientation; the histogram is scaled to unit length.

    Three things differ from Zaharescu et al. Neighbours are the vertices within a distance along the surface,
    so that another triangulation changes little. The axis is a mean and not the peak of a histogram, which
    would need an axis of its own. And there is one plane and not three, in which the sectors on both sides of
    the axis are joined, so that a mirror image or an inverted normal changes nothing.

    Parameters
    ----------
    mesh : MeshLike
        A mesh of triangles.
    radius : float
        Radius of the neighbourhood, as a share of the square root of the surface's area; twice the standard
        deviation σ of the weight.
    sectors : int
        Number of sectors, from 0° to 180° off the axis.
    orientations : int
        Number of orientations, from 0° to 360° off the axis; the first one is centred at 0°.
    smoothing : float
        Smoothing of the curvature, see `mean_curvature`.
    floor : float
        Length below which a histogram fades instead of being scaled to unit length, so that the noise of a
        plane or a sphere does not count as much as a shape. In units of a mean gradient times the area.

    Returns
    -------
    histograms : (n, sectors · orientations) array
        Each of length below 1.

    Raises
    ------
    ValueError
        If a parameter is out of range.
    MeshError
        If the shape is not a surface, or a vertex has no area.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> histograms = sg.mesh_hog((vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    >>> histograms.shape
    (4, 32)
    >>> bool((np.linalg.norm(histograms, axis=1) < 1).all())
    True
    """
    mesh = clean_surface(mesh)
    check_radius(radius)
    check_bins("sectors and orientations", sectors, orientations)
    if not 0 < floor < math.inf:
        raise ValueError(f"floor must be positive, not {floor}")
    unit = math.sqrt(mesh.area)
    gradients = unit**2 * vertex_gradients(mesh, mean_curvature(mesh, smoothing))
    points, areas, normals = mesh.vertices / unit, vertex_areas(mesh) / unit**2, vertex_normals(mesh)
    histograms = np.empty((len(points), sectors * orientations))
    for chunk, center, neighbor, distance in geodesic_neighbors(mesh, radius):
        count = chunk.stop - chunk.start
        weights = areas[neighbor] * np.exp(-((distance / radius) ** 2) * 2)
        total = np.bincount(center, weights, count)
        moved = weights[:, None] * gradients[neighbor]
        mean = np.stack([np.bincount(center, axis, count) for axis in moved.T], axis=1)
        first = _unit(mean - (mean * normals[chunk]).sum(axis=1, keepdims=True) * normals[chunk])
        second = np.cross(normals[chunk], first)
        x, y = (
            ((points[neighbor] - points[chunk][center]) * axis[center]).sum(axis=1)
            for axis in (first, second)
        )
        u, v = ((gradients[neighbor] * axis[center]).sum(axis=1) for axis in (first, second))
        v = np.where(y < 0, -v, v)
        sector = np.minimum(np.arctan2(np.abs(y), x) * (sectors / math.pi), sectors - 1).astype(np.int64)
        turn = np.rint(np.arctan2(v, u) * (orientations / (2 * math.pi))).astype(np.int64) % orientations
        cell = (center * sectors + sector) * orientations + turn
        summed = np.bincount(cell, weights * np.hypot(u, v), count * sectors * orientations)
        values = summed.reshape(count, -1) / np.maximum(total, np.finfo(float).tiny)[:, None]
        histograms[chunk] = values / np.sqrt((values**2).sum(axis=1, keepdims=True) + floor**2)
    return histograms


def _unit(vectors: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(lengths, np.finfo(float).tiny))
