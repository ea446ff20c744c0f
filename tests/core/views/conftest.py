# SPDX-License-Identifier: MIT
"""The shipped views, and a shape without symmetry."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import trimesh

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import load_model
from shapegoogle_core.views import ViewModel


@pytest.fixture(scope="session")
def views() -> ViewModel:
    shipped = load_model().views
    assert shipped is not None
    return shipped


Boxes = Sequence[tuple[tuple[float, float, float], tuple[float, float, float]]]


def make_boxes(boxes: Boxes, name: str) -> Mesh:
    """Boxes of some sizes at some places, as loose parts."""
    box = trimesh.creation.box()
    vertices = [np.asarray(box.vertices) * size + place for size, place in boxes]
    faces = [np.asarray(box.faces) + 8 * number for number in range(len(boxes))]
    return Mesh(np.concatenate(vertices), np.concatenate(faces), name)


@pytest.fixture(scope="session")
def chair() -> Mesh:
    """A chair with one arm: four legs, a seat, a back and the arm as loose parts."""
    legs = [((0.05, 0.05, 0.5), (x, y, 0.25)) for x in (-0.25, 0.25) for y in (-0.25, 0.25)]
    rest = [
        ((0.6, 0.6, 0.06), (0.0, 0.0, 0.53)),
        ((0.6, 0.06, 0.7), (0.0, 0.27, 0.9)),
        ((0.06, 0.5, 0.05), (0.28, 0.0, 0.75)),
    ]
    return make_boxes([*legs, *rest], "chair")


@pytest.fixture(scope="session")
def table() -> Mesh:
    """A table of loose parts."""
    legs = [((0.05, 0.05, 0.7), (x, y, 0.35)) for x in (-0.5, 0.5) for y in (-0.3, 0.3)]
    return make_boxes([*legs, ((1.2, 0.8, 0.05), (0.0, 0.0, 0.72))], "table")
