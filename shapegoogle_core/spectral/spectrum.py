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

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import BOUNDARIES, Operator, build_operator
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.spectral.eigensolver import smallest_pairs

__all__ = ["Spectrum", "compute_spectrum", "operator_spectrum"]

# Below this many vertices a dense solver is as fast as an iterative one, and cannot miss anything.
DENSE_SIZE = 200
# Finding the loaded libraries takes 1.5 ms, 5 % of a small spectrum: numpy's and scipy's are loaded by now.
_LIBRARIES = ThreadpoolController()


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The k smallest eigenpairs of a shape.

    Attributes
    ----------
    eigenvalues : (k,) array
        Ascending, ≥ 0, in 1 / squared mesh units. Exactly 0 once for each connected component that is not
        held at 0 on a boundary; of more such components than k, the largest are kept, and the others have no
        heat.
    eigenvectors : (n, k) array
        Orthonormal in their operator's mass: ΦᵀAΦ = I. In 1 / mesh units. The entry of largest magnitude
        of each is positive. Of an operator with degrees of freedom that are no vertices ("fem2", "fem3"),
        the values at the vertices: orthonormal only as nearly as `mass` integrates them.
    mass : (n,) array
        Lumped vertex areas in squared mesh units.
    """

    eigenvalues: FloatArray
    eigenvectors: FloatArray
    mass: FloatArray

    @property
    def area(self) -> float:
        """Surface area in squared mesh units."""
        return float(self.mass.sum())

    def at(self, vertices: NDArray[np.int64]) -> Spectrum:
        """Keep the values of the eigenfunctions at some vertices alone.

        Parameters
        ----------
        vertices : (p,) array of int

        Returns
        -------
        spectrum : Spectrum
            Its heat kernel is that between these vertices. Its eigenvectors are orthonormal no more, and its
            area is that of these vertices.
        """
        return Spectrum(self.eigenvalues, self.eigenvectors[vertices], self.mass[vertices])


def compute_spectrum(
    mesh: Mesh, k: int = 100, laplacian: str = "robust", boundary: str = "neumann"
) -> Spectrum:
    """Compute the k smallest eigenpairs of a mesh's Laplace–Beltrami operator (paper, equations 8 and 10).

    Parameters
    ----------
    mesh : Mesh
        Every vertex must belong to a face; for "point-cloud" there need not be any.
    k : int
        Number of eigenpairs; at most as many as the operator has free degrees of freedom are returned.
    laplacian : {"robust", "cotangent", "cotangent-voronoi", "fem1", "fem2", "fem3", "point-cloud"}
        The operator, see `shapegoogle_core.laplacian`.
    boundary : {"neumann", "dirichlet"}
        On open boundaries, the edges of one face only: "neumann", the natural condition, lets no heat
        through; "dirichlet" holds eigenvectors at 0. A closed surface has the same spectrum with both.

    Returns
    -------
    spectrum : Spectrum
        With min(k, n) pairs, n counting the vertices (of "fem2" and "fem3" all degrees of freedom) that are
        not held at 0.

    Raises
    ------
    ValueError
        If k < 1, or the operator or the boundary condition is unknown.
    MeshError
        If the operator cannot be assembled or its eigenproblem cannot be solved; with "dirichlet" also if
        everything lies on the boundary, or the boundary of a point cloud is asked for.
    """
    operator = build_operator(mesh, laplacian)
    if boundary == "dirichlet":
        if operator.boundary is None:
            raise MeshError(
                f"{mesh.name!r}: the boundary of points without faces is not known; use boundary='neumann'"
            )
        if len(operator.boundary) == operator.stiffness.shape[0]:
            raise MeshError(
                f"{mesh.name!r}: all its vertices lie on open edges, where boundary='dirichlet' leaves "
                "nothing; subdivide the mesh, or use boundary='neumann'"
            )
    try:
        return operator_spectrum(operator, k, boundary)
    except np.linalg.LinAlgError as error:
        raise MeshError(f"{mesh.name!r}: the eigenproblem could not be solved ({error})") from error


def operator_spectrum(operator: Operator, k: int = 100, boundary: str = "neumann") -> Spectrum:
    """Compute the k smallest solutions of W φ = λ A φ.

    Parameters
    ----------
    operator : Operator
    k : int
        Number of eigenpairs; at most as many as there are free degrees of freedom are returned.
    boundary : {"neumann", "dirichlet"}
        See `compute_spectrum`.

    Returns
    -------
    spectrum : Spectrum

    Raises
    ------
    ValueError
        If k < 1, the boundary condition is unknown, or "dirichlet" leaves no freedom or no boundary is known.

    Notes
    -----
    The spectrum of a shape is the union of its components'. They are solved one by one: a Krylov method
    would have to tell apart as many equal (zero) eigenvalues as there are components.

    BLAS gets one thread meanwhile: the products are so small that several mostly wait for each other, which
    took 5 to 20 times as long on a busy machine.
    """
    if k < 1:
        raise ValueError(f"k must be at least 1, not {k}")
    if boundary not in BOUNDARIES:
        raise ValueError(f"boundary must be one of {', '.join(BOUNDARIES)}, not {boundary!r}")
    with _LIBRARIES.limit(limits=1, user_api="blas"):
        if boundary == "dirichlet":
            return _held_spectrum(operator, k)
        grounded = np.zeros(operator.stiffness.shape[0], bool)
        eigenvalues, eigenvectors = _solve(operator, k, grounded)
        return _spectrum_at_vertices(operator, eigenvalues, eigenvectors)


def _held_spectrum(operator: Operator, k: int) -> Spectrum:
    """Eigenpairs that are 0 on the boundary: those of the rows and columns of the other freedoms."""
    count = operator.stiffness.shape[0]
    if operator.boundary is None:
        raise ValueError("the boundary of this operator is not known, so that nothing can be held at 0 there")
    free = np.ones(count, bool)
    free[operator.boundary] = False
    if not free.any():
        raise ValueError("all degrees of freedom lie on the boundary: none is left")
    inner = np.flatnonzero(free)
    stiffness = operator.stiffness[inner]
    grounded = np.diff(sparse.csr_array(stiffness[:, operator.boundary]).indptr) > 0
    held = Operator(stiffness[:, inner].tocsc(), operator.mass[inner][:, inner].tocsc())
    eigenvalues, inner_vectors = _solve(held, k, grounded)
    eigenvectors = np.zeros((count, len(eigenvalues)))
    eigenvectors[inner] = inner_vectors
    return _spectrum_at_vertices(operator, eigenvalues, eigenvectors)


def _spectrum_at_vertices(operator: Operator, eigenvalues: FloatArray, eigenvectors: FloatArray) -> Spectrum:
    """Leave out what is no vertex, and fix the signs."""
    areas = operator.lumped_mass
    # A slice would keep all of the array alive.
    at_vertices = eigenvectors if len(areas) == len(eigenvectors) else eigenvectors[: len(areas)].copy()
    largest = np.abs(at_vertices).argmax(axis=0)
    at_vertices *= np.where(at_vertices[largest, np.arange(len(eigenvalues))] < 0, -1.0, 1.0)
    return Spectrum(np.maximum(eigenvalues, 0.0), at_vertices, areas)


def _solve(operator: Operator, k: int, grounded: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Find the k smallest eigenpairs, in ascending order.

    `grounded` are the degrees of freedom beside some that are held at 0: the constant function of a connected
    component with one of them is no solution.
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
    """(d,) integrals of the basis functions, which sum to the area; some are 0 for quadratic elements."""
    return np.asarray(operator.mass.sum(axis=1), dtype=np.float64).ravel()


def _constants_of_largest(mass: FloatArray, component: np.ndarray, k: int) -> tuple[FloatArray, FloatArray]:
    """Take the constant functions of the k largest components: all wanted eigenvalues are 0.

    Every choice of k components would be right; the largest ones keep most of the surface, and the choice
    does not hang on rounding.
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
    members = np.split(np.argsort(component, kind="stable"), np.cumsum(np.bincount(component))[:-1])
    areas = np.array([weights[freedoms].sum() for freedoms in members])
    # Weyl: a component holds eigenvalues in proportion to its area. Ask for some more, then check.
    wanted = np.ceil(1.2 * k * areas / areas.sum()).astype(int) + 5
    pairs: list[tuple[FloatArray, FloatArray]] = [(np.empty(0), np.empty((0, 0)))] * len(members)
    pending = list(range(len(members)))
    while pending:
        for index in pending:
            freedoms = members[index]
            part = Operator(
                operator.stiffness[freedoms][:, freedoms].tocsc(),
                operator.mass[freedoms][:, freedoms].tocsc(),
            )
            most = min(wanted[index], k, len(freedoms))
            pairs[index] = _smallest_pairs(part, most, has_constant=not grounded[freedoms].any())
        known = np.sort(np.concatenate([values for values, _ in pairs]))
        threshold = known[k - 1] if len(known) >= k else np.inf
        # A component whose largest known eigenvalue lies below the k-th overall may hide more below it.
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


def _smallest_pairs(operator: Operator, k: int, has_constant: bool = True) -> tuple[FloatArray, FloatArray]:
    """Solve one connected component, in ascending order; its first function is the constant or none is."""
    n = operator.stiffness.shape[0]
    if n <= DENSE_SIZE or k > n // 3:
        values, vectors = scipy.linalg.eigh(
            operator.stiffness.toarray(), operator.mass.toarray(), subset_by_index=[0, k - 1]
        )
        if has_constant:
            values[0] = 0.0  # known exactly
        return values, vectors
    return smallest_pairs(operator.stiffness, operator.mass, k, constant=has_constant)
