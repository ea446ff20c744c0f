# SPDX-License-Identifier: MIT
"""The block Lanczos solver against a dense one, and that it cannot miss a pair unnoticed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sparse
import trimesh

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import Operator, build_operator
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import compute_spectrum, eigensolver, inertia
from shapegoogle_core.spectral.block_lanczos import BLOCK, block_lanczos
from shapegoogle_core.spectral.eigensolver import smallest_pairs
from shapegoogle_core.spectral.inertia import Factor
from shapegoogle_core.spectral.pencil import Pairs, Pencil
from tests.core.conftest import Shapes


def dense_eigenvalues(operator: Operator, k: int) -> FloatArray:
    values: FloatArray = scipy.linalg.eigh(
        operator.stiffness.toarray(),
        operator.mass.toarray(),
        eigvals_only=True,
        subset_by_index=[0, k - 1],
    )
    return values


def check(operator: Operator, k: int, constant: bool = False) -> None:
    """The promises: eigenvalues within 1e-8, true and orthonormal eigenvectors."""
    values, vectors = smallest_pairs(operator.stiffness, operator.mass, k, constant)
    expected = dense_eigenvalues(operator, k)
    floor = dense_eigenvalues(operator, min(k + 60, operator.stiffness.shape[0]))
    floor = floor[floor > 1e-9 * floor[-1]][0]
    np.testing.assert_array_less(np.abs(values - expected) / np.maximum(expected, floor), 1e-8)
    np.testing.assert_allclose(vectors.T @ (operator.mass @ vectors), np.eye(k), atol=1e-12)
    residual = operator.stiffness @ vectors - (operator.mass @ vectors) * values
    # In the norm of A⁻¹, with the lumped mass for A.
    sizes = np.linalg.norm(residual / np.sqrt(operator.lumped_mass)[:, None], axis=0)
    assert sizes.max() < 1e-7 * max(expected[-1], floor)


def with_dirichlet_boundary(operator: Operator, boundary: np.ndarray) -> Operator:
    inside = np.setdiff1d(np.arange(operator.stiffness.shape[0]), boundary)
    return Operator(
        sparse.csc_array(operator.stiffness[inside][:, inside]),
        sparse.csc_array(operator.mass[inside][:, inside]),
    )


def box(subdivisions: int) -> Mesh:
    mesh = trimesh.creation.box()
    for _ in range(subdivisions):
        mesh = mesh.subdivide()
    return Mesh(mesh.vertices, mesh.faces)


@pytest.mark.parametrize("laplacian", ["cotangent", "fem1"])
@pytest.mark.parametrize("k", [1, 2, 5, 100, 200])
def test_agrees_with_a_dense_solver(laplacian: str, k: int, bumpy: Mesh) -> None:
    check(build_operator(bumpy, laplacian), k)


@pytest.mark.parametrize("laplacian", ["cotangent", "fem1"])
@pytest.mark.parametrize("k", [1, 2, 30, 150])
def test_the_constant_is_exact_where_the_kernel_has_it(laplacian: str, k: int, bumpy: Mesh) -> None:
    operator = build_operator(bumpy, laplacian)
    check(operator, k, constant=True)
    values, vectors = smallest_pairs(operator.stiffness, operator.mass, k, constant=True)
    assert values[0] == 0
    np.testing.assert_allclose(vectors[:, 0], 1 / np.sqrt(operator.mass.sum()), rtol=1e-13)


@pytest.mark.parametrize("k", [16, 17, 49, 50, 120])
def test_multiple_eigenvalues_wherever_the_count_ends(k: int, shapes: type[Shapes]) -> None:
    check(build_operator(shapes.sphere(3), "cotangent"), k)
    check(build_operator(box(3), "fem1"), k)


@pytest.mark.parametrize("laplacian", ["cotangent", "fem1", "robust"])
def test_a_strip_has_fewer_eigenvalues_than_weyl_promises(laplacian: str, shapes: type[Shapes]) -> None:
    check(build_operator(shapes.rectangle(60.0, 0.2, 300), laplacian), 60)


@pytest.mark.parametrize("laplacian", ["cotangent", "fem1"])
def test_the_constant_need_not_be_in_the_kernel(laplacian: str, shapes: type[Shapes]) -> None:
    rectangle = shapes.rectangle(1.7, 1.0, 34)
    x, y = rectangle.vertices[:, :2].T
    edge = np.flatnonzero((x < 1e-9) | (y < 1e-9) | (x > 1.7 - 1e-9) | (y > y.max() - 1e-9))
    operator = with_dirichlet_boundary(build_operator(rectangle, laplacian), edge)
    assert dense_eigenvalues(operator, 1)[0] > 1
    check(operator, 80)


@pytest.mark.parametrize("k", [5, 60])
def test_more_equal_eigenvalues_than_a_block_has_vectors(k: int, shapes: type[Shapes]) -> None:
    one = build_operator(shapes.sphere(2), "cotangent")
    copies = 2 * BLOCK
    check(
        Operator(
            sparse.csc_array(sparse.block_diag([one.stiffness] * copies)),
            sparse.csc_array(sparse.block_diag([one.mass] * copies)),
        ),
        k,
    )


class Blind:
    """A random generator whose blocks lack the given directions."""

    def __init__(self, directions: FloatArray) -> None:
        self.directions = directions
        self.random = np.random.default_rng(1)

    def standard_normal(self, shape: tuple[int, int]) -> FloatArray:
        block = self.random.standard_normal(shape)
        for _ in range(2):
            block -= self.directions @ (self.directions.T @ block)
        return block


class Searches:
    """Stands in for `block_lanczos`; the first search starts without a share of the missed eigenvectors."""

    def __init__(self) -> None:
        self.search = block_lanczos
        self.missed: list[int] = []
        self.known: list[int] = []  # how many pairs each search was to keep away from

    def __call__(
        self,
        pencil: Pencil,
        factor: Factor,
        below: int,
        above: int,
        known: FloatArray,
        random: Any,
        room: int,
    ) -> tuple[Pairs, float]:
        if not self.known and self.missed:
            random = Blind(np.linalg.eigh(pencil.stiffness.toarray())[1][:, self.missed])
        self.known.append(known.shape[1])
        return self.search(pencil, factor, below, above, known, random, room)


@pytest.fixture
def searches(monkeypatch: pytest.MonkeyPatch) -> Searches:
    spy = Searches()
    monkeypatch.setattr(eigensolver, "block_lanczos", spy)
    return spy


def test_one_search_is_enough(searches: Searches, bumpy: Mesh) -> None:
    check(build_operator(bumpy, "cotangent"), 60)
    assert searches.known == [0]


@pytest.mark.parametrize("missed", [[57], [58, 59], [3], [0, 20, 58]])
def test_what_the_start_is_blind_to_is_found_all_the_same(
    missed: list[int], searches: Searches, bumpy: Mesh
) -> None:
    searches.missed = missed
    check(build_operator(bumpy, "cotangent"), 60)
    if min(missed) > 55:  # above the shift nothing but the count can tell
        assert searches.known == [0, 60]


def test_a_start_of_one_direction(monkeypatch: pytest.MonkeyPatch, bumpy: Mesh) -> None:
    class Narrow:
        def standard_normal(self, shape: tuple[int, int]) -> FloatArray:
            values: FloatArray = np.random.default_rng(2).standard_normal((shape[0], 1)) * np.ones(shape)
            return values

    search: Callable[..., tuple[Pairs, float]] = block_lanczos
    monkeypatch.setattr(eigensolver, "block_lanczos", lambda *given: search(*given[:-2], Narrow(), given[-1]))
    check(build_operator(bumpy, "cotangent"), 40)


def test_a_shift_at_an_eigenvalue_is_moved(monkeypatch: pytest.MonkeyPatch, bumpy: Mesh) -> None:
    operator = build_operator(bumpy, "cotangent")
    value = dense_eigenvalues(operator, 40)[24]
    monkeypatch.setattr(inertia, "SHARE_BELOW", value / (40 * 4 * np.pi / operator.mass.sum()))
    check(operator, 40)


def test_the_same_input_gives_the_same_output(bumpy: Mesh) -> None:
    operator = build_operator(bumpy, "fem1")
    first, second = (smallest_pairs(operator.stiffness, operator.mass, 50) for _ in range(2))
    np.testing.assert_array_equal(first[0], second[0])
    np.testing.assert_array_equal(first[1], second[1])


def test_a_count_that_never_agrees_is_an_error(monkeypatch: pytest.MonkeyPatch, shapes: type[Shapes]) -> None:
    bumpy = shapes.bumpy()
    monkeypatch.setattr(
        eigensolver, "countable_gap", lambda values, *_: (values[-1] * 1.0001, len(values) + 1)
    )
    with pytest.raises(MeshError, match="'Ada': its eigenpairs cannot be computed") as error:
        compute_spectrum(Mesh(bumpy.vertices, bumpy.faces, name="Ada"), 30)
    assert str(error.value.__cause__).startswith("found 31 eigenvalues")


def test_says_what_k_may_be(bumpy: Mesh) -> None:
    operator = build_operator(bumpy)
    for k in (0, len(bumpy.vertices) // 3 + 1):
        with pytest.raises(ValueError, match="between 1 and a third of the 642 unknowns"):
            smallest_pairs(operator.stiffness, operator.mass, k)


def test_a_dense_cluster_far_from_the_shift_is_resolved() -> None:
    """A column of many equal rings has one; the usual number of directions does not tell them apart."""
    ring = 342 + 1e-3 * np.arange(40)
    expected = np.concatenate([np.linspace(1, 300, 40), ring, np.linspace(400, 4000, 800)])
    stiffness, mass = sparse.diags_array(expected).tocsc(), sparse.eye_array(len(expected)).tocsc()
    values, _ = smallest_pairs(stiffness, mass, 67)
    np.testing.assert_allclose(values, expected[:67], rtol=1e-9)
