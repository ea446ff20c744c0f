# SPDX-License-Identifier: MIT
"""Checks that a surface can be described."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from numpy.typing import ArrayLike

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, check_surface

BALL = trimesh.creation.icosphere(subdivisions=3)


def test_surface_passes() -> None:
    for unit in (1e-12, 1.0, 1e12):
        check_surface(Mesh(BALL.vertices * unit, BALL.faces))
    check_surface(Mesh(BALL.vertices + 1e6, BALL.faces))


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (BALL.vertices, None, "no faces and 642 points"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], "only 3 vertices"),
        (np.full((4, 3), 7.5), [[0, 1, 2], [1, 2, 3]], "coincide"),
        (np.array([[1e6, 1e6, 1e6]] * 3 + [[1e6, 1e6, 1e6 + 1e-10]]), [[0, 1, 3]], "coincide"),
        (np.arange(12).reshape(-1, 1) * [1, 2, 3], [[0, 1, 2], [3, 7, 11]], "no area"),
        (
            (np.arange(12).reshape(-1, 1) * [0.1, 0.2, 0.3]).astype(np.float32),
            [[0, 1, 2], [3, 7, 11]],
            "no area",
        ),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 0, 1], [2, 2, 2]], "no area"),
        ([[0, 0, 0], [1e200, 0, 0], [0, 1e-190, 0], [1, 1e-190, 0]], [[0, 1, 2], [1, 3, 2]], "no area"),
        (BALL.vertices * 1e200, BALL.faces, "scale"),
        (BALL.vertices * 1e308, BALL.faces, "scale"),
        (BALL.vertices * 1e-200, BALL.faces, "scale"),
    ],
)
def test_everything_else_is_refused(vertices: ArrayLike, faces: ArrayLike | None, words: str) -> None:
    with pytest.raises(MeshError, match="'thing'") as caught:
        check_surface(Mesh(vertices, faces, "thing"))
    assert words in str(caught.value)


def test_one_is_singular() -> None:
    assert repr(Mesh(np.eye(3), [[0, 1, 2]])) == "Mesh('mesh', 3 vertices, 1 face)"
    with pytest.raises(MeshError, match="has only 1 vertex;"):
        check_surface(Mesh(np.zeros((1, 3)), [[0, 0, 0]]))
