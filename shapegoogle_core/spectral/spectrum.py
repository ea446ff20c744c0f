# SPDX-License-Identifier: MIT
"""Eigenvalues and eigenfunctions of the Laplace–Beltrami operator (paper, sections 3.2 and 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from threadpoolctl import ThreadpoolController

from shapegoogle_core.api.arguments import check_count
from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import BOUNDARIES, Operator, build_operator
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral.eigensolver import smallest_pairs

__all__ = ["Spectrum", "check_spectrum", "compute_spectrum", "operator_spectrum"]

# Up to this number of vertices a dense solver is as fast as an iterative one, and cannot miss a pair.
DENSE_SIZE = 200
# Made once, as finding the loaded libraries takes a while; those of numpy and scipy are loaded by now.
_LIBRARIES = ThreadpoolController()


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The k smallest eigenpairs of a shape, W φ = λ A φ (paper, equations 8 and 10).

    Attributes
    ----------
    eigenvalues : (k,) array
        Ascending, ≥ 0, in 1 / squared mesh units. Exactly 0 once for each connected component that is not
        held at 0 on a boundary. If there are more such components than k, the largest are kept, and the
        others have no heat.
    eigenvectors : (n, k) array
        Orthonormal in the mass of their operator, ΦᵀAΦ = I; in 1 / mesh units. The entry of largest magnitude
        of each eigenvector is positive. For an operator that also has degrees of freedom elsewhere than at
        vertices ("fem2", "fem3"), the values at the vertices, which are orthonormal only as far as `mass`
        integrates them.
    mass : (n,) array
        Lumped vertex areas in squared mesh units.

    See Also
    --------
    compute_spectrum : Spectrum of a mesh.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> spectrum = sg.compute_spectrum((vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    >>> spectrum.eigenvalues.round(4).tolist()
    [0.0, 0.6667, 0.6667, 0.6667]
    >>> spectrum.eigenvectors.shape, round(spectrum.area, 4)
    ((4, 4), 13.8564)
    """

    eigenvalues: FloatArray
    eigenvectors: FloatArray
    mass: FloatArray

    @property
    def area(self) -> float:
        """Surface area in squared mesh units."""
        return float(self.mass.sum())

    def at(self, vertices: NDArray[np.int64]) -> Spectrum:
        """Restrict the eigenvectors to some vertices.

        Parameters
        ----------
        vertices : (p,) array of int
            Indices of the vertices to keep.

        Returns
        -------
        spectrum : Spectrum
            Its heat kernel is that between these vertices. Its eigenvectors are no longer orthonormal, and
            its area is that of these vertices.
        """
        return Spectrum(self.eigenvalues, self.eigenvectors[vertices], self.mass[vertices])


def check_spectrum(spectrum: object) -> None:
    """Raise ValueError unless an argument is a `Spectrum`.

    Parameters
    ----------
    spectrum : object

    Raises
    ------
    ValueError
        If it is something else, such as the mesh itself.
    """
    if not isinstance(spectrum, Spectrum):
        raise ValueError(
            f"a Spectrum is needed, not {type(spectrum).__name__}; pass compute_spectrum(mesh) of the mesh"
        )


def compute_spectrum(
    mesh: MeshLike, k: int = 100, laplacian: str = "robust", boundary: str = "neumann"
) -> Spectrum:
    """Compute the k smallest eigenpairs of the Laplace–Beltrami operator (paper, equations 8 and 10).

    Parameters
    ----------
    mesh : MeshLike
        A mesh in which every vertex belongs to a face, or points for "point-cloud".
    k : int
        Number of eigenpairs.
    laplacian : {"robust", "cotangent", "cotangent-voronoi", "fem1", "fem2", "fem3", "point-cloud"}
        Operator, see `build_operator`.
    boundary : {"neumann", "dirichlet"}
        Condition on open boundaries, the edges of only one face: "neumann", the natural condition, lets no
        heat through; "dirichlet" holds eigenvectors at 0. A closed surface has the same spectrum with both.

    Returns
    -------
    spectrum : Spectrum
        With min(k, n) pairs, where n counts the vertices (for "fem2" and "fem3" all degrees of freedom) that
        are not held at 0.

    Raises
    ------
    ValueError
        If k is not a whole number ≥ 1, or the operator or the boundary condition is unknown.
    MeshError
        If the operator cannot be assembled or its eigenproblem cannot be solved; with "dirichlet" also if
        all vertices lie on the boundary, or the mesh is a point cloud, whose boundary is not known.

    See Also
    --------
    build_operator : Stiffness and mass alone.
    heat_kernel_signature : Descriptor of each vertex, computed from a spectrum.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> mesh = sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    >>> spectrum = sg.compute_spectrum(mesh, k=3, laplacian="cotangent")
    >>> spectrum.eigenvalues.round(4).tolist()
    [0.0, 0.6667, 0.6667]
    """
    mesh = as_mesh(mesh)
    operator = build_operator(mesh, laplacian)
    if boundary == "dirichlet":
        if operator.boundary is None:
            raise MeshError(
                f"{mesh.name!r}: the boundary of points without faces is not known; use boundary='neumann'"
            )
        if len(operator.boundary) == operator.stiffness.shape[0]:
            raise MeshError(
                f"{mesh.name!r}: all its vertices lie on open edges, where boundary='dirichlet' holds them "
                "at 0; subdivide the mesh, or use boundary='neumann'"
            )
    try:
        return operator_spectrum(operator, k, boundary)
    except np.linalg.LinAlgError as error:
        raise MeshError(
            f"{mesh.name!r}: its eigenpairs cannot be computed; repair it or mesh it again"
        ) from error


def operator_spectrum(operator: Operator, k: int = 100, boundary: str = "neumann") -> Spectrum:
    """Compute the k smallest solutions of W φ = λ A φ.

    Parameters
    ----------
    operator : Operator
        Stiffness W and mass A, see `build_operator`.
    k : int
        Number of eigenpairs; not more are returned than there are free degrees of freedom.
    boundary : {"neumann", "dirichlet"}
        See `compute_spectrum`.

    Returns
    -------
    spectrum : Spectrum

    Raises
    ------
    ValueError
        If k is not a whole number ≥ 1, the boundary condition is unknown, or, with "dirichlet", the
        boundary is not known or all degrees of freedom lie on it.
    numpy.linalg.LinAlgError
        If the eigenproblem cannot be solved.

    Notes
    -----
    The spectrum of a shape is the union of those of its connected components. They are solved one by one: a
    Krylov method would have to separate as many equal (zero) eigenvalues as there are components.

    BLAS is limited to one thread meanwhile: the products are so small that several threads mostly wait for
    each other (docs/measurements/speed.md).
    """
    check_count("k", k)
    if boundary not in BOUNDARIES:
        raise ValueError(f"boundary must be one of {', '.join(BOUNDARIES)}, not {boundary!r}")
    with _LIBRARIES.limit(limits=1, user_api="blas"):
        if boundary == "dirichlet":
            return _held_spectrum(operator, k)
        grounded = np.zeros(operator.stiffness.shape[0], bool)
        eigenvalues, eigenvectors = _solve(operator, k, grounded)
        return _spectrum_at_vertices(operator, eigenvalues, eigenvectors)


def _held_spectrum(operator: Operator, k: int) -> Spectrum:
    """Solve for eigenfunctions that are 0 on the boundary: for the rows and columns of the other freedoms."""
    count = operator.stiffness.shape[0]
    if operator.boundary is None:
        raise ValueError("the boundary of this operator is not known, which boundary='dirichlet' needs")
    free = np.ones(count, bool)
    free[operator.boundary] = False
    if not free.any():
        raise ValueError("all degrees of freedom of the operator lie on the boundary: none is left")
    inner = np.flatnonzero(free)
    stiffness = operator.stiffness[inner]
    grounded = np.diff(sparse.csr_array(stiffness[:, operator.boundary]).indptr) > 0
    held = Operator(stiffness[:, inner].tocsc(), operator.mass[inner][:, inner].tocsc())
    eigenvalues, inner_vectors = _solve(held, k, grounded)
    eigenvectors = np.zeros((count, len(eigenvalues)))
    eigenvectors[inner] = inner_vectors
    return _spectrum_at_vertices(operator, eigenvalues, eigenvectors)


def _spectrum_at_vertices(operator: Operator, eigenvalues: FloatArray, eigenvectors: FloatArray) -> Spectrum:
    """Keep the degrees of freedom at vertices, and fix the signs."""
    areas = operator.lumped_mass
    # A copy, as a slice would keep the whole array alive.
    at_vertices = eigenvectors if len(areas) == len(eigenvectors) else eigenvectors[: len(areas)].copy()
    largest = np.abs(at_vertices).argmax(axis=0)
    at_vertices *= np.where(at_vertices[largest, np.arange(len(eigenvalues))] < 0, -1.0, 1.0)
    return Spectrum(np.maximum(eigenvalues, 0.0), at_vertices, areas)


def _solve(operator: Operator, k: int, grounded: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Find the k smallest eigenpairs, in ascending order.

    `grounded` marks the degrees of freedom next to those that are held at 0: the constant function is no
    solution on a connected component that contains one of them.
    """
    weights = _freedom_weights(operator)
    k = min(k, len(weights))
    component_count, component = connected_components(operator.stiffness, directed=False)
    if component_count == 1:
        return _smallest_pairs(operator, k, has_constant=not grounded.any())
    if component_count >= k and not grounded.any():
        return _constants_of_largest(weights, component, k)
    return _union_of_components(operator, component, k, grounded)


def _freedom_weights(operator: Operator) -> FloatArray:
    """Integrate the d basis functions. They sum to the area; some are 0 for quadratic elements."""
    return np.asarray(operator.mass.sum(axis=1), dtype=np.float64).ravel()


def _constants_of_largest(mass: FloatArray, component: np.ndarray, k: int) -> tuple[FloatArray, FloatArray]:
    """Return the constant functions of the k largest components: all wanted eigenvalues are 0.

    Any k components would do. The largest keep most of the surface, and the choice does not depend on
    rounding.
    """
    areas = np.bincount(component, mass)
    largest = np.argsort(-areas, kind="stable")[:k]
    constants = np.where(component[:, None] == largest, 1 / np.sqrt(areas[largest]), 0.0)
    return np.zeros(k), constants


def _union_of_components(
    operator: Operator, component: np.ndarray, k: int, grounded: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Merge the spectra of the connected components and keep the k smallest."""
    weights = _freedom_weights(operator)
    order = np.argsort(component, kind="stable")
    bounds = np.concatenate([[0], np.cumsum(np.bincount(component))])
    members = np.split(order, bounds[1:-1])
    # Sorted by component the matrices are block diagonal, and blocks are cheap to cut out.
    stiffness, mass = (
        sparse.csc_array(matrix[order][:, order]) for matrix in (operator.stiffness, operator.mass)
    )
    areas = np.array([weights[freedoms].sum() for freedoms in members])
    # Weyl's law: a component has eigenvalues in proportion to its area. Compute some more, then check.
    wanted = np.ceil(1.2 * k * areas / areas.sum()).astype(int) + 5
    pairs: list[tuple[FloatArray, FloatArray]] = [(np.empty(0), np.empty((0, 0)))] * len(members)
    pending = list(range(len(members)))
    while pending:
        for index in pending:
            freedoms = members[index]
            start, end = bounds[index : index + 2]
            part = Operator(_diagonal_block(stiffness, start, end), _diagonal_block(mass, start, end))
            most = min(wanted[index], k, len(freedoms))
            pairs[index] = _smallest_pairs(part, most, has_constant=not grounded[freedoms].any())
        known = np.sort(np.concatenate([values for values, _ in pairs]))
        threshold = known[k - 1] if len(known) >= k else np.inf
        # A component whose largest known eigenvalue lies below the k-th of all may have more below that.
        pending = [
            index
            for index, (values, _) in enumerate(pairs)
            if len(values) < min(k, len(members[index])) and values[-1] < threshold
        ]
        wanted[pending] *= 2
    eigenvalues = np.concatenate([values for values, _ in pairs])
    owner = np.repeat(np.arange(len(members)), [len(values) for values, _ in pairs])
    position = np.concatenate([np.arange(len(values)) for values, _ in pairs])
    smallest = np.argsort(eigenvalues, kind="stable")[:k]
    eigenvectors = np.zeros((len(component), k))
    for column, (index, place) in enumerate(zip(owner[smallest], position[smallest], strict=True)):
        eigenvectors[members[index], column] = pairs[index][1][:, place]
    return eigenvalues[smallest], eigenvectors


def _diagonal_block(matrix: sparse.csc_array, start: int, end: int) -> sparse.csc_array:
    """Cut rows and columns start to end out of a matrix whose columns have no entries in other rows."""
    starts = matrix.indptr[start : end + 1]
    entries = slice(starts[0], starts[-1])
    content = matrix.data[entries], matrix.indices[entries] - start, starts - starts[0]
    return sparse.csc_array(content, shape=(end - start, end - start))


def _smallest_pairs(operator: Operator, k: int, has_constant: bool = True) -> tuple[FloatArray, FloatArray]:
    """Solve one connected component, in ascending order. If it has a constant function, that is the first."""
    n = operator.stiffness.shape[0]
    if n <= DENSE_SIZE or k > n // 3:
        values, vectors = scipy.linalg.eigh(
            operator.stiffness.toarray(), operator.mass.toarray(), subset_by_index=[0, k - 1]
        )
        if has_constant:
            values[0] = 0.0  # known exactly
        return values, vectors
    return smallest_pairs(operator.stiffness, operator.mass, k, constant=has_constant)
