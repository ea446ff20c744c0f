# SPDX-License-Identifier: MIT
"""Descriptions of whole shapes from before Shape Google, as baselines."""

from __future__ import annotations

import math

import numpy as np
import trimesh
from scipy.special import roots_jacobi, roots_legendre

from shapegoogle_core.descriptors import global_point_signature
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, face_areas
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import Spectrum

__all__ = [
    "D2_BINS",
    "D2_RANGE",
    "D2_SAMPLES",
    "d2_distribution",
    "diffusion_distances",
    "gps_distances",
    "shape_dna",
    "surface_moments",
]

D2_SAMPLES = 1 << 17
"""Number of pairs of points; Osada et al. take 1024², with a third of the sampling noise."""

D2_BINS = 64

D2_RANGE = 3.0
"""End of the histogram in mean distances: the length of a thin rod."""

_LEAST_DECAY = 1e-4
"""Least decay of eigenfunctions that contribute to a diffusion distance."""


def shape_dna(spectrum: Spectrum, count: int = 49) -> FloatArray:
    """Compute Shape-DNA: the first Laplace–Beltrami eigenvalues (Reuter, Wolter, Peinecke 2006).

    Eigenvalues are multiplied by the area, so that size does not matter, and the j-th is divided by 4πj, its
    value on any surface for large j by Weyl's law. Without this division the last eigenvalues, whose
    differences grow with j, would dominate the Euclidean distance.

    Parameters
    ----------
    spectrum : Spectrum
        Of more than `count` pairs.
    count : int
        Number of eigenvalues; the first, which is 0 on every surface, is left out.

    Returns
    -------
    dna : (count,) array
        λ_j A / 4πj for j = 1 … count, without a unit; compare by the Euclidean distance. A shape of c parts
        that do not touch starts with c − 1 zeros, which characterise it. A coarse mesh has fewer
        eigenvalues than `count`; the others are 1, as in Weyl's law.

    Raises
    ------
    ValueError
        If count < 1.
    """
    if count < 1:
        raise ValueError(f"Shape-DNA needs at least one eigenvalue, not {count}")
    dna = np.ones(count)
    known = spectrum.eigenvalues[1 : count + 1]
    dna[: len(known)] = known * spectrum.area / (4 * np.pi * np.arange(1, len(known) + 1))
    return dna


def d2_distribution(mesh: Mesh, samples: int = D2_SAMPLES, bins: int = D2_BINS, seed: int = 0) -> FloatArray:
    """Compute the D2 shape distribution: distances of random points of a surface (Osada et al. 2002).

    Parameters
    ----------
    mesh : Mesh
    samples : int
        Number of pairs of points, uniform on the surface. The error of the histogram decreases with its
        square root.
    bins : int
    seed : int
        Of the points.

    Returns
    -------
    histogram : (bins,) array
        Share of the pairs whose distance, divided by the mean distance, falls into equal bins of
        0 … `D2_RANGE`; the last bin includes larger distances. Sums to 1; compare by the L1 distance, as
        Osada et al. do.

    Raises
    ------
    MeshError
        If the mesh has no surface.
    ValueError
        If there are no samples or no bins.
    """
    if samples < 1 or bins < 1:
        raise ValueError(f"D2 needs at least one sample and one bin, not {samples} and {bins}")
    if not mesh.area > 0:
        raise MeshError(f"{mesh.name!r} has no surface to take points from")
    surface = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    points = trimesh.sample.sample_surface(surface, 2 * samples, seed=seed)[0]
    return _distance_histogram(points, bins)


def diffusion_distances(
    spectrum: Spectrum, time: float = 0.1, samples: int = D2_SAMPLES, bins: int = D2_BINS, seed: int = 0
) -> FloatArray:
    """Compute the histogram of diffusion distances on a surface (Mahmoudi and Sapiro 2009).

    d_t(x, y)² = Σ_l exp(-2 λ_l t) (φ_l(x) - φ_l(y))²: the difference of the heat that
    spreads from the two points, which a shortcut through a hole or a bridge changes little.

    Parameters
    ----------
    spectrum : Spectrum
    time : float
        t > 0, as a share of the area.
    samples : int
        Number of pairs of vertices, drawn with probabilities proportional to their areas.
    bins : int
    seed : int
        Of the points.

    Returns
    -------
    histogram : (bins,) array
        As for `d2_distribution`; compare by the L1 distance.

    Raises
    ------
    ValueError
        If there are no samples or no bins, or the time is not positive.
    """
    if not 0 < time < math.inf:
        raise ValueError(f"the time must be a positive share of the area, not {time}")
    decay = np.exp(-spectrum.eigenvalues * spectrum.area * time)
    seen = decay > _LEAST_DECAY
    return _embedded(spectrum, spectrum.eigenvectors[:, seen] * decay[seen], samples, bins, seed)


def gps_distances(
    spectrum: Spectrum, count: int = 25, samples: int = D2_SAMPLES, bins: int = D2_BINS, seed: int = 0
) -> FloatArray:
    """Compute the histogram of distances between points of a surface in its GPS embedding (Rustamov 2007).

    This is the D2 distribution of the embedding by the global point signature, which is independent of the
    pose: signs of eigenfunctions, and their order for nearly equal eigenvalues, only rotate and reflect the
    embedding. Unlike Rustamov's G2 it is not divided into shells.

    Parameters
    ----------
    spectrum : Spectrum
    count : int
        Dimensions of the embedding.
    samples : int
        Number of pairs of vertices, drawn with probabilities proportional to their areas.
    bins : int
    seed : int
        Of the points.

    Returns
    -------
    histogram : (bins,) array
        As for `d2_distribution`; compare by the L1 distance.

    Raises
    ------
    ValueError
        If there are no dimensions, no samples or no bins.
    """
    return _embedded(spectrum, global_point_signature(spectrum, count), samples, bins, seed)


def surface_moments(mesh: Mesh, order: int = 7) -> FloatArray:
    """Compute moments of a surface in its principal axes (Elad, Tal, Ar 2001).

    m_pqr = ∫ x^p y^q z^r dS / ∫ dS for 2 ≤ p + q + r ≤ order, exact up to rounding. The surface is translated
    to its centroid, rotated to its principal axes, the longest first, and scaled to a mean squared distance
    of 1 from the centroid. Because the direction of an axis is arbitrary, absolute values are taken; their
    (p + q + r)-th roots are lengths, without which the highest moments would dominate.

    Parameters
    ----------
    mesh : Mesh
    order : int

    Returns
    -------
    moments : (m,) array
        116 for order 7, without unit; by p + q + r, then p descending, then q descending. Those of
        order 2 are the spreads along the axes, and zeros. Compare by the L1 distance.

    Raises
    ------
    MeshError
        If the mesh has no surface.
    ValueError
        If order < 2.
    """
    if order < 2:
        raise ValueError(f"moments of order 2 at least are needed, not {order}")
    areas = face_areas(mesh)
    if not areas.sum() > 0:
        raise MeshError(f"{mesh.name!r} has no surface to take moments of")
    points, weights = _quadrature(mesh.vertices[mesh.faces], areas / areas.sum(), order)
    points = points - weights @ points
    spread, axes = np.linalg.eigh((points * weights[:, None]).T @ points)
    points = points @ axes[:, ::-1] / math.sqrt(spread.sum())
    powers = points[None] ** np.arange(order + 1)[:, None, None]
    exponents = [
        (p, q, total - p - q)
        for total in range(2, order + 1)
        for p in range(total, -1, -1)
        for q in range(total - p, -1, -1)
    ]
    moments = [
        abs(float(weights @ (powers[p, :, 0] * powers[q, :, 1] * powers[r, :, 2]))) ** (1 / (p + q + r))
        for p, q, r in exponents
    ]
    return np.array(moments)


def _quadrature(triangles: FloatArray, areas: FloatArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """Return points and weights that integrate polynomials up to a degree exactly over triangles.

    Gauss rules on a square collapsed to a triangle, with a Gauss–Jacobi rule along the collapsing side.
    """
    count = degree // 2 + 1
    along, along_weights = roots_jacobi(count, 1, 0)
    aside, aside_weights = roots_legendre(count)
    u, v = np.meshgrid((along + 1) / 2, (aside + 1) / 2, indexing="ij")
    shares = np.outer(along_weights, aside_weights).ravel() / 4
    corners = np.stack([u, (1 - u) * v, (1 - u) * (1 - v)], axis=-1).reshape(-1, 3)
    points = np.einsum("qc,fcd->fqd", corners, triangles).reshape(-1, 3)
    return points, np.outer(areas, shares).ravel()


def _embedded(spectrum: Spectrum, embedding: FloatArray, samples: int, bins: int, seed: int) -> FloatArray:
    """Compute the histogram of distances of random vertices in an embedding of the surface."""
    if samples < 1 or bins < 1:
        raise ValueError(f"a histogram needs at least one sample and one bin, not {samples} and {bins}")
    random = np.random.default_rng(seed)
    chosen = random.choice(len(embedding), 2 * samples, p=spectrum.mass / spectrum.area)
    return _distance_histogram(embedding[chosen], bins)


def _distance_histogram(points: FloatArray, bins: int) -> FloatArray:
    """Compute the histogram of distances between the two halves of the points, divided by their mean."""
    samples = len(points) // 2
    distances = np.linalg.norm(points[:samples] - points[samples:], axis=1)
    # All distances are 0 if all points coincide, as for a polygon soup without positive eigenvalues.
    relative = np.minimum(distances / max(distances.mean(), np.finfo(float).tiny), D2_RANGE)
    counts, _ = np.histogram(relative, bins, (0.0, D2_RANGE))
    histogram: FloatArray = counts / samples
    return histogram
