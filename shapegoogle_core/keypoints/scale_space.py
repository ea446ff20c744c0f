# SPDX-License-Identifier: MIT
"""Detectors in scale space: differences between two smoothings of a function or of the surface itself."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array

from shapegoogle_core.keypoints.harris import fit_quadrics
from shapegoogle_core.keypoints.surroundings import adjacency, discs, maxima_in
from shapegoogle_core.laplacian import Operator, build_operator, heat_step
from shapegoogle_core.mesh.connectivity import boundary_vertices
from shapegoogle_core.mesh.measures import vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.spectral import Spectrum

__all__ = ["diffusions", "mesh_dog", "salient_points", "signed_mean_curvature"]


def diffusions(operator: Operator, values: FloatArray, times: FloatArray) -> list[FloatArray]:
    """Smooth functions by heat flow, in implicit steps from each time to the next.

    (A + (tᵢ - tᵢ₋₁) W) fᵢ = A fᵢ₋₁, Gaussian smoothing of variance 2t for any triangulation.

    Parameters
    ----------
    operator : Operator
        Stiffness W and mass A.
    values : (n,) or (n, d) array
        Functions at time 0.
    times : (s,) array
        Ascending, > 0, in squared mesh units.

    Returns
    -------
    smoothed : list of s arrays like `values`
        Functions at each time.
    """
    mass = operator.lumped_mass
    smoothed, before = [], 0.0
    for time in times:
        values = np.asarray(heat_step(operator, time - before).solve((mass * values.T).T))
        smoothed.append(values)
        before = float(time)
    return smoothed


def signed_mean_curvature(mesh: Mesh, operator: Operator) -> FloatArray:
    """Compute the mean curvature H of every vertex: half the Laplacian of the positions, along the normal.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.
    operator : Operator
        Laplacian of the mesh.

    Returns
    -------
    curvature : (n,) array
        In 1 / mesh units; 1/r on a sphere of radius r whose normals point outwards. At open boundaries, where
        the Laplacian is not that of the surface, the mean of the neighbours.

    See Also
    --------
    shapegoogle_core.descriptors.mean_curvature : Smoothed, and without sign.
    """
    along = (np.asarray(operator.stiffness @ mesh.vertices) * vertex_normals(mesh)).sum(axis=1)
    curvature: FloatArray = 0.5 * along / operator.lumped_mass
    rim = boundary_vertices(mesh)
    if rim.any():
        inner = adjacency(mesh) @ diags_array((~rim).astype(float))
        count = np.asarray(inner.sum(axis=1)).ravel()
        nearby = np.asarray(inner @ curvature) / np.maximum(count, 1)
        curvature = np.where(rim, nearby, curvature)
    return curvature


def mesh_dog(
    mesh: Mesh,
    spectrum: Spectrum,
    smallest: float = 0.04,
    largest: float = 0.24,
    edge_ratio: float = 10.0,
    threshold: float = 0.1,
) -> FloatArray:
    """Find extrema of the mean curvature in scale space (Zaharescu, Boyer, Varanasi, Horaud 2009).

    Let f(σ) be the mean curvature smoothed by a Gaussian of standard deviation σ. Keypoints are the extrema
    of f(√2 σ) - f(σ) over place and scale, except those on ridges.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.
    spectrum : Spectrum
        Spectrum of the mesh, of which the areas are used.
    smallest, largest : float
        Range of σ, as shares of √area: the sizes of the features. Steps are √2.
    edge_ratio : float
        e, the largest ratio of the principal curvatures r₁ and r₂ of the difference around a keypoint: it is
        a ridge if (r₁ + r₂)² / r₁r₂ exceeds (e + 1)² / e, or if r₁ and r₂ have different signs (Lowe 2004,
        section 4.1).
    threshold : float
        Least difference at a keypoint, as a share of the largest anywhere.

    Returns
    -------
    response : (n,) array
        |f(√2 σ) - f(σ)| √area at the keypoints, 0 at the other vertices; dimensionless.

    Raises
    ------
    ValueError
        If `largest` is less than `smallest`.
    MeshError
        If the operator cannot be assembled.

    Notes
    -----
    Zaharescu et al. smooth over rings of neighbours and keep 5 % of the vertices; heat flow and a share of
    the largest difference make the result independent of the triangulation. The function is the mean
    curvature, one of those that they propose, as meshes here have no colours.
    """
    operator = build_operator(mesh, "robust")
    # One more scale below and one more difference above: an extremum is compared with the neighbouring
    # scales.
    sigma = _scales(smallest, largest, below=1, above=2)
    curvature = signed_mean_curvature(mesh, operator) * np.sqrt(spectrum.area)
    differences = np.diff(diffusions(operator, curvature, sigma**2 / 2 * spectrum.area), axis=0)
    joined, rings, inside = adjacency(mesh), discs(mesh, 0.0), ~boundary_vertices(mesh)
    response = np.zeros(len(mesh.vertices))
    for sign in (1, -1):
        around = [_largest_of(sign * difference, joined) for difference in differences]
        for below, here, above in zip(around, sign * differences[1:-1], around[2:], strict=False):
            highest = maxima_in(here, joined) & (here > np.maximum(np.maximum(below, above), 0)) & inside
            centers = np.flatnonzero(highest)
            p1, p2, p3, *_ = fit_quadrics(mesh, spectrum.mass, rings[centers], centers, here).T
            round_ones = centers[(p1 + p3) ** 2 * edge_ratio < (p1 * p3 - p2**2) * (edge_ratio + 1) ** 2]
            response[round_ones] = np.maximum(response[round_ones], here[round_ones])
    return np.where(response >= threshold * np.abs(differences[1:-1]).max(), response, 0.0)


def _scales(smallest: float, largest: float, below: int, above: int) -> FloatArray:
    """List the scales from the smallest to the largest in steps of √2, and some more below and above."""
    if largest < smallest:
        raise ValueError(f"the scale largest={largest} must not be below smallest={smallest}")
    first = smallest / np.sqrt(2) ** below
    steps = round(2 * np.log2(largest / first))
    return np.asarray(first * np.sqrt(2) ** np.arange(steps + 1 + above))


def _largest_of(values: FloatArray, joined: csr_array) -> FloatArray:
    return np.maximum.reduceat(values[joined.indices], joined.indptr[:-1])


def salient_points(
    mesh: Mesh,
    spectrum: Spectrum,
    smallest: float = 0.03,
    largest: float = 0.12,
    radius: float = 0.08,
    threshold: float = 0.5,
) -> FloatArray:
    """Find where smoothing moves the surface most (Castellani, Cristani, Fantoni, Murino 2008).

    Let x(σ) be the positions smoothed by a Gaussian of standard deviation σ. The map of a scale is |n·(x(2σ)
    - x(σ))|. Maps are scaled to a largest value of 1 and weighted by (1 - m)², where m is the mean of their
    other maxima: a map with a few high peaks counts, one with many similar peaks does not (Itti, Koch, Niebur
    1998). Keypoints are the maxima of the sum of the maps.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.
    spectrum : Spectrum
        Spectrum of the mesh, of which the area is used.
    smallest, largest : float
        Range of σ, as shares of √area. Steps are √2.
    radius : float
        Radius of the surroundings in which a keypoint has the largest value, as a share of √area; no two
        keypoints are closer.
    threshold : float
        Least value of a keypoint, as a share of the largest.

    Returns
    -------
    response : (n,) array
        The sum at the keypoints, 0 at the other vertices; dimensionless.

    Raises
    ------
    ValueError
        If `largest` is less than `smallest`.
    MeshError
        If the operator cannot be assembled.
    """
    operator = build_operator(mesh, "robust")
    sigma = _scales(smallest, largest, below=0, above=2)
    smoothed = diffusions(operator, mesh.vertices, sigma**2 / 2 * spectrum.area)
    normals, joined = vertex_normals(mesh), adjacency(mesh)
    inside = ~boundary_vertices(mesh)
    saliency = np.zeros(len(mesh.vertices))
    for narrow, wide in zip(smoothed, smoothed[2:], strict=False):
        moved = np.abs(((wide - narrow) * normals).sum(axis=1)) * inside
        if not moved.any():
            continue  # a flat surface does not move
        moved /= moved.max()
        others = np.sort(moved[maxima_in(moved, joined)])[:-1]
        saliency += moved * (1 - (others.mean() if len(others) else 0.0)) ** 2
    high = maxima_in(saliency, joined) & (saliency > 0) & (saliency >= threshold * saliency.max())
    peaks = np.flatnonzero(high)
    found = maxima_in(saliency, discs(mesh, radius * np.sqrt(spectrum.area), peaks), peaks)
    return np.where(found, saliency, 0.0)
