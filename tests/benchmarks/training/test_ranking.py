# SPDX-License-Identifier: MIT
"""Learning the order by shape and kind."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from benchmarks.training.ranking import Group, learn_ranking
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.signature import ShapeSignature


@pytest.fixture(scope="module")
def model() -> ShapeModel:
    return load_model()


@pytest.fixture(scope="module")
def signatures(model: ShapeModel) -> list[ShapeSignature]:
    meshes = [
        *(trimesh.creation.box((1, 1, length)) for length in (5, 6, 7)),
        *(trimesh.creation.torus(1, radius, major_sections=24, minor_sections=12) for radius in (0.2, 0.25)),
        *(trimesh.creation.box((3, 3 + 0.2 * wide, 0.2)) for wide in (0, 1)),
    ]
    return [model.describe(Mesh(mesh.vertices, mesh.faces)) for mesh in meshes]


def test_the_order_is_chosen_by_what_it_finds(model: ShapeModel, signatures: list[ShapeSignature]) -> None:
    labels = np.array(["rod", "rod", "rod", "ring", "ring", "plate", "plate"])
    group = Group("solids", labels, np.arange(7), True, signatures)
    ranking, report = learn_ranking(model, [group])
    assert ranking.view_weight + ranking.bag_weight + ranking.figure_weight == pytest.approx(1)
    assert ranking.likeness(0.5 * ranking.likeness_half) > 0.5 > ranking.likeness(2 * ranking.likeness_half)
    assert "the three together" in report
    assert "100.0 100.0" in report.splitlines()[-1]
