# SPDX-License-Identifier: MIT
"""Discs on surfaces, and maxima in them."""

from __future__ import annotations

import numpy as np

import shapegoogle_core as sg
from shapegoogle_core.keypoints.surroundings import adjacency, discs, maxima_in
from tests.core.conftest import Shapes


class TestSurroundings:
    def test_discs_of_a_plane_are_round(self, shapes: type[Shapes]) -> None:
        plane = shapes.rectangle(1, 1, 20)
        distance = np.linalg.norm(plane.vertices[:, None] - plane.vertices[None], axis=2)
        # A disc of 4.2 edges holds two rings.
        assert np.array_equal(discs(plane, 0.21).toarray() > 0, distance <= 0.21)

    def test_the_other_side_of_a_sheet_is_not_near(self, shapes: type[Shapes]) -> None:
        front = shapes.rectangle(1, 1, 10)
        back = sg.Mesh(front.vertices + np.array([0, 0, 0.01]), front.faces)
        n = len(front.vertices)
        both = sg.Mesh(
            np.concatenate([front.vertices, back.vertices]), np.concatenate([front.faces, back.faces + n])
        )
        assert discs(both, 0.3)[:n, n:].nnz == 0

    def test_maxima(self, shapes: type[Shapes]) -> None:
        plane = shapes.rectangle(1, 1, 10)
        values = -np.linalg.norm(plane.vertices - [0.5, 0.5, 0], axis=1)
        assert np.flatnonzero(maxima_in(values, adjacency(plane))).tolist() == [5 * 11 + 5]
        # Of a plateau the first.
        assert np.flatnonzero(maxima_in(np.zeros(121), discs(plane, 2.0))).tolist() == [0]
