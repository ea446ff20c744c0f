# SPDX-License-Identifier: MIT
"""Harris 3D, a detector of corners (Sipiran and Bustos 2010; paper, section 3.1)."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from shapegoogle_core.keypoints.surroundings import discs, maxima_in
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh
from shapegoogle_core.spectral import Spectrum

__all__ = ["fit_quadrics", "harris_3d", "harris_response"]

# Share of the normal matrix that is added to it, so that a fit to fewer points than coefficients is solvable.
_RIDGE = 1e-6


def harris_3d(
    mesh: Mesh, spectrum: Spectrum, radius: float = 0.04, trace_weight: float = 0.04, threshold: float = 3e-3
) -> FloatArray:
    """Find corners, points around which the surface bends in every direction (Sipiran, Bustos 2010).

    A quadric z = p₁x²/2 + p₂xy + p₃y²/2 + p₄x + p₅y + p₆ is fitted to the surroundings of each vertex, with x
    and y in their principal plane and the vertex at the origin. E is the mean of ∇z∇zᵀ under a Gaussian
    window of standard deviation `radius`, and the response is h = det E - k (tr E)².

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.
    spectrum : Spectrum
        Its areas weight the vertices.
    radius : float
        Radius of the surroundings and of the window, as a share of √area; no two keypoints are closer.
    trace_weight : float
        k: the larger, the fewer ridges count as corners. 0.04 as in Harris and Stephens.
    threshold : float
        Least response of a keypoint, as a share of the largest. Responses grow with the fourth power of the
        curvature: 3e-3 keeps points a quarter as sharp as the sharpest.

    Returns
    -------
    response : (n,) array
        h at the keypoints, 0 at the other vertices; dimensionless.

    Notes
    -----
    Sipiran and Bustos take maxima among the neighbours along edges, and then those of highest response or
    clusters of them. Maxima in discs do both, at any resolution.
    """
    size = radius * np.sqrt(spectrum.area)
    joined = discs(mesh, size)
    quadrics = fit_quadrics(mesh, spectrum.mass, joined, np.arange(len(mesh.vertices)), unit=size)
    values = harris_response(quadrics, trace_weight)
    found = maxima_in(values, joined) & (values > 0) & (values >= threshold * values.max())
    return np.where(found, values, 0.0)


def harris_response(quadrics: FloatArray, trace_weight: float = 0.04) -> FloatArray:
    """Compute the response det E - k (tr E)² of quadrics under a Gaussian window of standard deviation 1.

    As the means of x² and y² are 1 and those of xy, x and y are 0, E is ((p₄² + p₁² + p₂², p₄p₅ + p₂(p₁ +
    p₃)), (…, p₅² + p₂² + p₃²)). The window of Sipiran and Bustos has variance 2, which doubles each square of
    a curvature.

    Parameters
    ----------
    quadrics : (n, 6) array
        p₁ … p₆ in units of the window.
    trace_weight : float
        k.

    Returns
    -------
    response : (n,) array
        h of each quadric.
    """
    p1, p2, p3, p4, p5, _ = quadrics.T
    along_x = p4**2 + p1**2 + p2**2
    along_y = p5**2 + p2**2 + p3**2
    mixed = p4 * p5 + p2 * (p1 + p3)
    return np.asarray(along_x * along_y - mixed**2 - trace_weight * (along_x + along_y) ** 2)


def fit_quadrics(
    mesh: Mesh,
    mass: FloatArray,
    joined: sparse.csr_array,
    centers: IntArray | NDArray[np.int64],
    values: FloatArray | None = None,
    unit: float = 1.0,
) -> FloatArray:
    """Fit quadrics to the surroundings of vertices, by least squares weighted by area.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.
    mass : (n,) array
        Areas of the vertices.
    joined : (c, n) sparse array
        Surroundings of the c centres, rows of `discs`.
    centers : (c,) array of int
        Vertices at the origin of the quadrics.
    values : (n,) array, optional
        Function over the principal plane of the surroundings. Default: the height above the plane.
    unit : float
        Unit of x, y and z, in the unit of the mesh.

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
    # The axes are in order of ascending spread: the normal of the principal plane comes first.
    z, y, x = np.einsum("pi,pij->jp", offsets, axes[place])
    height = z if values is None else values[joined.indices]
    terms = np.stack([x**2 / 2, x * y, y**2 / 2, x, y, np.ones_like(x)], axis=1)
    matrix = np.stack([mean(terms * terms[:, [row]]) for row in range(6)], axis=1)
    # Each coefficient is scaled by its own size, so that the ridge does not depend on the unit.
    scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), np.finfo(float).tiny))
    matrix = matrix / (scale[:, :, None] * scale[:, None, :]) + _RIDGE * np.eye(6)
    right = mean(terms * height[:, None]) / scale
    return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0] / scale)
