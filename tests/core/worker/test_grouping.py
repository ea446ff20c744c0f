# SPDX-License-Identifier: MIT
"""Meshes that are in no library, described and grouped by requests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shapegoogle_core import ModelError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.worker.grouping import describe_meshes, group_meshes
from shapegoogle_core.worker.packed import Packed


def test_a_mesh_that_cannot_be_described_costs_only_itself(model: ShapeModel, meshes: list[Mesh]) -> None:
    larger = Mesh(2 * meshes[0].vertices, meshes[0].faces)
    described = describe_meshes(model, [Mesh(np.zeros((4, 3)), name="a speck"), meshes[0], larger])
    assert isinstance(described[0], str)
    assert "a speck" in described[0]
    ((first, second),) = group_meshes(model, described)
    assert (first, second[0]) == ((1, 1.0), 2)
    assert second[1] > 0.99
    other = [replace(packed, model="another") for packed in described if isinstance(packed, Packed)]
    with pytest.raises(ModelError, match="taken the place"):
        group_meshes(model, other)
