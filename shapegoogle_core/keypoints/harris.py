# SPDX-License-Identifier: MIT
"""Harris 3D: corners of the surface (Sipiran and Bustos 2010)."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from shapegoogle_core.keypoints.surroundings import discs, maxima_in
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh
from shapegoogle_core.spectral import Spectrum

__all__ = ["fit_quadrics", "harris_3d", "harris_response"]

# So small a share of the normal matrix keeps a fit to fewer points than it has coefficients solvable.
_RIDGE = 1e-6


def harris_3d(
    mesh: Mesh, spectrum: Spectrum, radius: float = 0.04, trace_weight: float = 0.04, threshold: float = 3e-3
) -> FloatArray:
    """Find corners of the surface: points around which it bends in every direction (Sipiran, Bustos 2010).

    A quadric z = p₁x²/2 + p₂xy + p₃y²/2 + p₄x + p₅y + p₆ is laid through the surroundings of each vertex, x
    and y in their principal plane, the vertex at its origin. E is the mean of ∇z∇zᵀ under a Gaussian window
    of standard deviation `radius`, and the response h = det E - k (tr E)².

    Parameters
    ----------
    mesh : Mesh
    spectrum : Spectrum
        Its areas weight the vertices.
    radius : float
        Of the surroundings and the window, as a share of √area; no two points are closer.
    trace_weight : float
        k: the larger, the less may ridges look like corners. 0.04 as Harris and Stephens have it.
    threshold : float
        Least response of a point, as a share of the largest. Responses go with the fourth power of the
        curvature: 3e-3 are points a quarter as sharp as the sharpest.

    Returns
    -------
    response : (n,) array
        h at the points found, 0 at the other vertices; without unit.

    Notes
    -----
    Sipiran and Bustos take maxima among the neighbours along edges, then those of the highest responses or
    clusters of them. Maxima in discs do both, whatever the resolution.
    """
    size = radius * np.sqrt(spectrum.area)
    joined = discs(mesh, size)
    quadrics = fit_quadrics(mesh, spectrum.mass, joined, np.arange(len(mesh.vertices)), unit=size)
    values = harris_response(quadrics, trace_weight)
    found = maxima_in(values, joined) & (values > 0) & (values >= threshold * values.max())
    return np.where(found, values, 0.0)


def harris_response(quadrics: FloatArray, trace_weight: float = 0.04) -> FloatArray:
    """Response of quadrics: det E - k (tr E)² under a Gaussian window of standard deviation 1.

    As the mean of x² and of y² is 1 and that of xy, x and y is 0, E is ((p₄² + p₁² + p₂², p₄p₅ + p₂(p₁ +
    p₃)), (…, p₅² + p₂² + p₃²)). Sipiran and Bustos have a window of variance 2: each square of a curvature
    twice.

    Parameters
    ----------
    quadrics : (n, 6) array
        p₁ … p₆ in units of the window.
    trace_weight : float
        k.

    Returns
    -------
    response : (n,) array
    """
    p1, p2, p3, p4, p5, _ = quadrics.T
    along_x = p4**2 + p1**2 + p2**2
    along_y = p5**2 + p2**2 + p3**2
    mixed = p4 * p5 + p2 * (p1 + p3)
    response: FloatArray = along_x * along_y - mixed**2 - trace_weight * (along_x + along_y) ** 2
    return response


def fit_quadrics(
    mesh: Mesh,
    mass: FloatArray,
    joined: sparse.csr_array,
    centers: IntArray | NDArray[np.int64],
    values: FloatArray | None = None,
    unit: float = 1.0,
) -> FloatArray:
    """Lay a quadric through the surroundings of vertices, by least squares weighted by area.

    Parameters
    ----------
    mesh : Mesh
    mass : (n,) array
        Areas of the vertices.
    joined : (c, n) sparse array
        Surroundings of the c centers, rows of `discs`.
    centers : (c,) array of int
        Vertices at the origin of the quadrics.
    values : (n,) array, optional
        Function over the principal plane of the surroundings. Left out: the height above it.
    unit : float
        Of x, y and z, in the unit of the mesh.

    Returns
    -------
    quadrics : (c, 6) array
        p₁ … p₆ of z = p₁x²/2 + p₂xy + p₃y²/2 + p₄x + p₅y + p₆.
    """
    if len(centers) == 0:
        return np.empty((0, 6))
    first, place = joined.indptr[:-1], np.repeat(np.arange(len(centers)), np.diff(joined.indptr))
    offsets = (mesh.vertices[joined.indices] - mesh.vertices[centers[place]]) / unit
    weights = mass[joined.indices]
    weights = weights / np.add.reduceat(weights, first)[place]

    def mean(terms: FloatArray) -> FloatArray:
        return np.add.reduceat(weights[:, None] * terms, first, axis=0)

    spread = offsets - mean(offsets)[place]
    covariance = np.stack([mean(spread * spread[:, [axis]]) for axis in range(3)], axis=1)
    _, axes = np.linalg.eigh(covariance)
    # Axes come by ascending spread: the normal of the principal plane first.
    z, y, x = np.einsum("pi,pij->jp", offsets, axes[place])
    height = z if values is None else values[joined.indices]
    terms = np.stack([x**2 / 2, x * y, y**2 / 2, x, y, np.ones_like(x)], axis=1)
    matrix = np.stack([mean(terms * terms[:, [row]]) for row in range(6)], axis=1)
    # Every coefficient by its own size, so that the unit does not matter to the ridge.
    scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), np.finfo(float).tiny))
    matrix = matrix / (scale[:, :, None] * scale[:, None, :]) + _RIDGE * np.eye(6)
    right = mean(terms * height[:, None]) / scale
    return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0] / scale)
