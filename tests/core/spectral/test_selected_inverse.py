# SPDX-License-Identifier: MIT
"""The diagonal of an inverse against the whole inverse."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core.laplacian import build_operator
from shapegoogle_core.spectral.selected_inverse import inverse_diagonal, level_structure
from tests.core.conftest import Shapes


def random_matrix(size: int, entries: int, seed: int) -> sparse.csr_array:
    """Symmetric and diagonally dominant, of any graph: loose vertices, parts and hubs."""
    random = np.random.default_rng(seed)
    rows, columns = random.integers(0, size, (2, entries))
    values = random.standard_normal(entries)
    half = sparse.csr_array((values, (rows, columns)), shape=(size, size))
    matrix = half + half.T
    return sparse.csr_array(
        matrix + sparse.diags_array(abs(matrix).sum(axis=1) + random.uniform(0.1, 1, size))
    )


@given(size=st.integers(1, 400), density=st.floats(0, 3), seed=st.integers(0, 99))
@settings(max_examples=40, deadline=None)
def test_any_graph(size: int, density: float, seed: int) -> None:
    matrix = random_matrix(size, int(density * size), seed)
    levels = level_structure(matrix)
    assert sorted(levels.order) == list(range(size))
    expected = np.diag(np.linalg.inv(matrix.toarray()))
    np.testing.assert_allclose(inverse_diagonal(matrix, levels), expected, rtol=1e-10)


def test_levels_join_only_neighbours(shapes: type[Shapes]) -> None:
    graph = build_operator(shapes.sphere(4)).stiffness.tocsr()
    levels = level_structure(graph)
    block = np.empty(len(levels.order), int)
    block[levels.order] = np.searchsorted(levels.bounds, np.arange(len(levels.order)), side="right")
    entries = graph.tocoo()
    assert np.abs(block[entries.row] - block[entries.col]).max() == 1
    assert len(levels.bounds) > 20


def test_says_when_the_matrix_is_not_positive_definite(shapes: type[Shapes]) -> None:
    stiffness = build_operator(shapes.sphere(2)).stiffness.tocsr()
    with pytest.raises(np.linalg.LinAlgError, match="positive definite"):
        inverse_diagonal(-stiffness, level_structure(stiffness))
