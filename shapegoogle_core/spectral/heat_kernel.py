# SPDX-License-Identifier: MIT
"""The heat kernel of a surface, from its spectrum or from its operator (paper, sections 3.1 and 3.3)."""

from __future__ import annotations

from numpy.typing import ArrayLike

from shapegoogle_core.laplacian import Operator, build_operator
from shapegoogle_core.mesh import MeshLike
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral.rational import rational_diagonal, rational_kernel
from shapegoogle_core.spectral.spectrum import Spectrum
from shapegoogle_core.spectral.truncated import truncated_diagonal, truncated_kernel

__all__ = ["METHODS", "checked_shape", "heat_kernel", "heat_kernel_diagonal"]

METHODS = ("spectral", "rational")
"""Ways to compute a heat kernel: from a truncated spectrum, or from an operator by rational approximation."""


def heat_kernel(
    shape: Spectrum | Operator | MeshLike,
    source: int,
    time: float,
    *,
    method: str = "spectral",
    tolerance: float = 0.01,
) -> FloatArray:
    """Heat at every vertex at time t after one unit was placed at the source (paper, equation 5).

    K_t(x, y) = Σ_l exp(-λ_l t) φ_l(x) φ_l(y)

    Parameters
    ----------
    shape : Spectrum, Operator or MeshLike
        A `Spectrum` for the method "spectral"; an operator with a value for each vertex, see
        `build_operator`, or a mesh for the method "rational".
    source : int
        Vertex x.
    time : float
        t > 0, in squared mesh units. With "rational" at most ten times the area; a spectrum serves all later
        times.
    method : {"spectral", "rational"}
        "spectral" sums over the eigenpairs of the spectrum, exact once the omitted terms have decayed.
        "rational" gives the sum over all eigenpairs, of which none are computed, at any time however small.
    tolerance : float
        Of "rational" only: largest error as a share of √(K_t(x, x) K_t(y, y)), which the kernel itself
        nowhere exceeds. Proved at y = x; the error is usually a hundred times smaller.

    Returns
    -------
    heat : (n,) array
        K_t(x, y) for all y, in 1 / squared mesh units. Its integral is 1, unless the component of x was left
        out of the spectrum. Where there is next to no heat, "rational" is 0 only to within the tolerance, and
        may be negative; with "fem1" the discrete kernel itself is.

    Raises
    ------
    ValueError
        If the method is unknown or needs another kind of shape, the source is not a vertex, the time
        is not positive, or, with "rational", another parameter is out of range, the operator has values
        elsewhere than at vertices ("fem2", "fem3"), or the tolerance cannot be proved.
    MeshError
        If the operator of the mesh cannot be assembled.

    See Also
    --------
    heat_kernel_signature : Heat that remains at each vertex, K_t(x, x).

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> vertices = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    >>> tetrahedron = sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    >>> spectrum = sg.compute_spectrum(tetrahedron)
    >>> heat = sg.heat_kernel(spectrum, source=0, time=2.0)
    >>> bool(heat.argmax() == 0), round(float(heat @ spectrum.mass), 6)
    (True, 1.0)
    >>> exact = sg.heat_kernel(tetrahedron, source=0, time=2.0, method="rational")
    >>> bool(np.allclose(exact, heat, rtol=1e-3))
    True
    """
    checked = checked_shape(shape, method)
    if isinstance(checked, Spectrum):
        return truncated_kernel(checked, source, time)
    return rational_kernel(checked, source, time, tolerance)


def heat_kernel_diagonal(
    shape: Spectrum | Operator | MeshLike,
    times: ArrayLike,
    *,
    method: str = "spectral",
    spectrum: Spectrum | None = None,
    tolerance: float = 0.01,
) -> FloatArray:
    """Heat that remains at every vertex at time t after one unit was placed there (paper, equation 6).

    K_t(x, x) = Σ_l exp(-λ_l t) φ_l(x)²

    Parameters
    ----------
    shape : Spectrum, Operator or MeshLike
        See `heat_kernel`.
    times : (d,) array_like
        Times t > 0, in squared mesh units. With "rational" and without a spectrum at most ten times the area.
    method : {"spectral", "rational"}
        See `heat_kernel`.
    spectrum : Spectrum, optional
        Of "rational" only: the operator's spectrum, of any size. The values at times at which what it leaves
        out is proved to be within the tolerance are taken from it.
    tolerance : float
        Of "rational" only: largest error as a share of K_t(x, x), proved at every vertex and time, rounding
        aside. The error is usually a hundred times smaller.

    Returns
    -------
    values : (n, d) array
        In 1 / squared mesh units.

    Raises
    ------
    ValueError
        If the method is unknown or needs another kind of shape, a time is not positive, or, with
        "rational", another parameter is out of range, the spectrum is of another operator, the operator has
        values elsewhere than at vertices ("fem2", "fem3"), or the tolerance cannot be proved, which happens
        on very uneven meshes.
    MeshError
        If the operator of the mesh cannot be assembled, or its stiffness has negative eigenvalues.
    """
    checked = checked_shape(shape, method)
    if isinstance(checked, Spectrum):
        return truncated_diagonal(checked, times)
    return rational_diagonal(checked, times, spectrum, tolerance)


def checked_shape(shape: Spectrum | Operator | MeshLike, method: str) -> Spectrum | Operator:
    """Return the spectrum or the operator that a method works on.

    Parameters
    ----------
    shape : Spectrum, Operator or MeshLike
    method : {"spectral", "rational"}

    Returns
    -------
    checked : Spectrum or Operator

    Raises
    ------
    ValueError
        If the method is unknown, or needs another kind of shape.
    MeshError
        If the operator of the mesh cannot be assembled.
    """
    if method not in METHODS:
        raise ValueError(f"method must be one of {', '.join(METHODS)}, not {method!r}")
    if method == "spectral":
        if not isinstance(shape, Spectrum):
            raise ValueError(
                f"method='spectral' needs a Spectrum, not {type(shape).__name__}; call compute_spectrum() "
                "first, or use method='rational'"
            )
        return shape
    if isinstance(shape, Spectrum):
        raise ValueError(
            "method='rational' needs a mesh or an operator, not a Spectrum; pass the mesh, or use "
            "method='spectral'"
        )
    return shape if isinstance(shape, Operator) else build_operator(shape)
