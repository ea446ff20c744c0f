# SPDX-License-Identifier: MIT
"""Properties of every operator."""

from __future__ import annotations

import numpy as np
import pytest

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import LAPLACIANS, build_operator
from shapegoogle_core.mesh import Mesh
from tests.core.conftest import Shapes


@pytest.mark.parametrize("laplacian", sorted(LAPLACIANS))
def test_is_symmetric_and_semidefinite_and_its_masses_sum_to_the_area(
    laplacian: str, shapes: type[Shapes]
) -> None:
    mesh = shapes.bumpy(2)
    operator = build_operator(mesh, laplacian)
    for matrix in (operator.stiffness, operator.mass):
        np.testing.assert_allclose((matrix - matrix.T).toarray(), 0, atol=1e-12)
    np.testing.assert_allclose(operator.stiffness.sum(axis=1), 0, atol=1e-10)
    assert np.linalg.eigvalsh(operator.stiffness.toarray())[0] > -1e-9
    assert np.linalg.eigvalsh(operator.mass.toarray())[0] > 0
    # Points without faces stand on a surface that only nearly is this one.
    accuracy = 0.01 if laplacian == "point-cloud" else 1e-9
    assert operator.mass.sum() == pytest.approx(mesh.area, rel=accuracy)
    assert operator.lumped_mass.shape == (len(mesh.vertices),)
    assert operator.lumped_mass.sum() == pytest.approx(mesh.area, rel=accuracy)


def test_points_on_a_line_have_no_operator() -> None:
    line = Mesh(np.outer(np.arange(50.0), [1, 2, 3]), name="ray")
    with pytest.raises(MeshError, match="'ray': all its points lie on a line"):
        build_operator(line, "point-cloud")
