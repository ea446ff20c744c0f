# SPDX-License-Identifier: MIT
"""Similarity transformations: they are undone by their inverse, and found again from pairs of points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from shapegoogle_core.registration.frames import Frame, similarity_transformations


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.2, 5))
def test_a_frame_and_its_inverse(seed: int, scale: float) -> None:
    random = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed % 2**31).as_matrix()
    frame = Frame(scale, turn, random.normal(size=3))
    points = random.normal(size=(5, 3))
    np.testing.assert_allclose(frame.apply_inverse(frame.apply(points)), points, atol=1e-9)
    np.testing.assert_allclose(frame.inverse().apply(frame.apply(points)), points, atol=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.2, 5))
def test_similarity_transformation_is_found_again(seed: int, scale: float) -> None:
    random = np.random.default_rng(seed)
    points, weights = random.standard_normal((2, 9, 3)), random.uniform(0.1, 1, (2, 9))
    turns = Rotation.random(2, random_state=seed % 2**31).as_matrix()
    shift = random.standard_normal((2, 1, 3))
    moved = scale * points @ turns.transpose(0, 2, 1) + shift
    scales, rotations, translations = similarity_transformations(points, moved, weights)
    np.testing.assert_allclose(scales, scale)
    np.testing.assert_allclose(rotations, turns, atol=1e-9)
    np.testing.assert_allclose(translations, shift[:, 0], atol=1e-9)


def test_a_mirror_image_gives_no_reflection() -> None:
    points = np.random.default_rng(0).standard_normal((1, 20, 3))
    _, rotations, _ = similarity_transformations(points, points * [1, 1, -1], np.ones((1, 20)))
    assert np.linalg.det(rotations[0]) == pytest.approx(1)
