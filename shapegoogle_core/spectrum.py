# SPDX-License-Identifier: MIT
"""Eigenvalues and eigenfunctions of the Laplace–Beltrami operator (paper, sections 3.2 and 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.eigensolver import smallest_pairs
from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import Operator, build_operator
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["Spectrum", "compute_spectrum", "operator_spectrum"]

# Below this many vertices a dense solver is as fast as an iterative one, and cannot miss anything.
DENSE_SIZE = 200


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The k smallest eigenpairs of a shape.

    Attributes
    ----------
    eigenvalues : (k,) array
        Ascending, ≥ 0, in 1 / squared mesh units. Exactly 0 once for each connected component; of more
        components than k, the largest are kept, and the others have no heat.
    eigenvectors : (n, k) array
        Orthonormal in their operator's mass: ΦᵀAΦ = I. In 1 / mesh units. The entry of largest magnitude
        of each is positive.
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


def compute_spectrum(mesh: Mesh, k: int = 100, laplacian: str = "robust") -> Spectrum:
    """Compute the k smallest eigenpairs of a mesh's Laplace–Beltrami operator (paper, equations 8 and 10).

    Parameters
    ----------
    mesh : Mesh
        Every vertex must belong to a face.
    k : int
        Number of eigenpairs; at most as many as the mesh has vertices are returned.
    laplacian : {"robust", "cotangent", "fem1"}
        The operator, see `shapegoogle_core.laplacian`. Natural (Neumann) conditions on open boundaries.

    Returns
    -------
    spectrum : Spectrum
        With min(k, n) pairs.

    Raises
    ------
    ValueError
        If k < 1 or the operator is unknown.
    MeshError
        If the operator cannot be assembled or its eigenproblem cannot be solved.
    """
    operator = build_operator(mesh, laplacian)
    try:
        return operator_spectrum(operator, k)
    except np.linalg.LinAlgError as error:
        raise MeshError(f"{mesh.name!r}: the eigenproblem could not be solved ({error})") from error


def operator_spectrum(operator: Operator, k: int = 100) -> Spectrum:
    """Compute the k smallest solutions of W φ = λ A φ.

    Parameters
    ----------
    operator : Operator
    k : int
        Number of eigenpairs; at most n are returned.

    Returns
    -------
    spectrum : Spectrum

    Notes
    -----
    The spectrum of a shape is the union of its components'. They are solved one by one: a Krylov method
    would have to tell apart as many equal (zero) eigenvalues as there are components.
    """
    if k < 1:
        raise ValueError(f"k must be at least 1, not {k}")
    mass = operator.lumped_mass
    k = min(k, len(mass))
    component_count, component = connected_components(operator.stiffness, directed=False)
    if component_count == 1:
        eigenvalues, eigenvectors = _smallest_pairs(operator, k)
    elif component_count >= k:
        eigenvalues, eigenvectors = _constants_of_largest(mass, component, k)
    else:
        eigenvalues, eigenvectors = _union_of_components(operator, component, k)
    largest = np.abs(eigenvectors).argmax(axis=0)
    eigenvectors *= np.where(eigenvectors[largest, np.arange(k)] < 0, -1.0, 1.0)
    return Spectrum(np.maximum(eigenvalues, 0.0), eigenvectors, mass)


def _constants_of_largest(mass: FloatArray, component: np.ndarray, k: int) -> tuple[FloatArray, FloatArray]:
    """Take the constant functions of the k largest components: all wanted eigenvalues are 0.

    Every choice of k components would be right; the largest ones keep most of the surface, and the choice
    does not hang on rounding.
    """
    areas = np.bincount(component, mass)
    largest = np.argsort(-areas, kind="stable")[:k]
    constants = np.where(component[:, None] == largest, 1 / np.sqrt(areas[largest]), 0.0)
    return np.zeros(k), constants


def _union_of_components(operator: Operator, component: np.ndarray, k: int) -> tuple[FloatArray, FloatArray]:
    """Merge the spectra of the connected components and keep the k smallest."""
    mass = operator.lumped_mass
    members = np.split(np.argsort(component, kind="stable"), np.cumsum(np.bincount(component))[:-1])
    areas = np.array([mass[vertices].sum() for vertices in members])
    # Weyl: a component holds eigenvalues in proportion to its area. Ask for some more, then check.
    wanted = np.ceil(1.2 * k * areas / areas.sum()).astype(int) + 5
    pairs: list[tuple[FloatArray, FloatArray]] = [(np.empty(0), np.empty((0, 0)))] * len(members)
    pending = list(range(len(members)))
    while pending:
        for index in pending:
            vertices = members[index]
            part = Operator(
                operator.stiffness[vertices][:, vertices].tocsc(),
                operator.mass[vertices][:, vertices].tocsc(),
            )
            pairs[index] = _smallest_pairs(part, min(wanted[index], k, len(vertices)))
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


def _smallest_pairs(operator: Operator, k: int) -> tuple[FloatArray, FloatArray]:
    """Solve one connected component, in ascending order."""
    n = operator.stiffness.shape[0]
    if n <= DENSE_SIZE or k > n // 3:
        values, vectors = scipy.linalg.eigh(
            operator.stiffness.toarray(), operator.mass.toarray(), subset_by_index=[0, k - 1]
        )
        values[0] = 0.0  # the constant function's, known exactly
        return values, vectors
    return smallest_pairs(operator.stiffness, operator.mass, k, constant=True)
