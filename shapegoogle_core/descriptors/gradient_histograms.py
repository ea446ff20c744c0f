# SPDX-License-Identifier: MIT
"""Mesh HOG: histograms of the gradient of a function on the surface (Zaharescu et al. 2009)."""

from __future__ import annotations

import math

import numpy as np

from shapegoogle_core.descriptors.checks import check_bins, check_radius
from shapegoogle_core.descriptors.geodesics import geodesic_neighbors
from shapegoogle_core.laplacian import cotangent, heat_step
from shapegoogle_core.mesh.connectivity import boundary_vertices
from shapegoogle_core.mesh.measures import vertex_areas, vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["mean_curvature", "mesh_hog", "vertex_gradients"]


def mean_curvature(mesh: Mesh, smoothing: float = 3e-3) -> FloatArray:
    """Mean curvature of every vertex, smoothed and without its sign.

    The Laplacian of the positions is twice the mean curvature along the normal, Δx = -2 H n. With the
    cotangent stiffness W, the areas A and the time t of an implicit step of heat flow, which takes off the
    noise that two derivatives bring forth: |H| = ½ ‖(A + tW)⁻¹ W x‖. On an open boundary W x is taken as 0.
    Where the sign counts there is `keypoints.scale_space.signed_mean_curvature`.

    Parameters
    ----------
    mesh : Mesh
    smoothing : float
        t as a share of the area: waves shorter than 2π √(t · area) lose more than half of their height.

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
    # There it is the pull of the rim, however flat the surface.
    bending[boundary_vertices(mesh)] = 0
    factor = heat_step(operator, smoothing * operator.lumped_mass.sum())
    curvature: FloatArray = 0.5 * np.linalg.norm(factor.solve(bending), axis=1)
    return curvature


def vertex_gradients(mesh: Mesh, values: FloatArray) -> FloatArray:
    """Gradient of a function along the surface, at every vertex: the mean of its faces', by area.

    On a face of unit normal n and area a the gradient is Σ_k f_k n × e_k / 2a, where e_k is the side opposite
    to corner k.

    Parameters
    ----------
    mesh : Mesh
    values : (n,) array
        f at the vertices.

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
    gradients: FloatArray = summed / np.maximum(vertex_areas(mesh), np.finfo(float).tiny)[:, None]
    return gradients


def mesh_hog(
    mesh: Mesh,
    radius: float = 0.2,
    sectors: int = 4,
    orientations: int = 8,
    smoothing: float = 3e-3,
    floor: float = 10.0,
) -> FloatArray:
    """Mesh HOG of every vertex, of the mean curvature (paper, section 3.2).

    The gradients of the mean curvature around x are laid into the tangent plane at x, whose first axis is
    their mean. Their lengths, with a Gaussian weight of the distance, are summed by the sector in which they
    stand and by their orientation; the histogram is brought to unit length.

    Three things differ from Zaharescu et al.: neighbours are those within a distance along the surface, so
    that another triangulation changes little; the axis is a mean and not the peak of a histogram, which
    would need an axis of its own; and there is one plane and not three, on which a neighbourhood and its
    mirror image, or a normal to the other side, give the same: sectors on one side of the axis are laid onto
    those of the other.

    Parameters
    ----------
    mesh : Mesh
    radius : float
        Of the neighbourhood, as a share of the root of the surface's area; twice the width σ of the weight.
    sectors : int
        How many, from 0° to 180° off the axis.
    orientations : int
        How many, from 0° to 360° against the axis; the first one is around 0°.
    smoothing : float
        Of `mean_curvature`.
    floor : float
        Length below which a histogram is not brought to unit length but fades, so that the noise of a plane
        or a sphere does not count as much as a shape. As a mean gradient, times the area.

    Returns
    -------
    histograms : (n, sectors · orientations) array
        Of length below 1.

    Raises
    ------
    ValueError
        If a parameter is out of range.
    """
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
