# SPDX-License-Identifier: MIT
"""All detectors: what must not change what they find, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import shapegoogle_core as sg
from shapegoogle_core.keypoints import DETECTORS, detect_keypoints
from tests.core.conftest import Shapes
from tests.core.keypoints.bumps import keypoints


@pytest.mark.parametrize("detector", DETECTORS)
class TestEveryDetector:
    @settings(max_examples=5, deadline=None)
    @given(seed=st.integers(0, 2**32 - 1))
    def test_motion_scale_and_order_of_vertices_do_not_matter(
        self, bumpy: sg.Mesh, detector: str, seed: int
    ) -> None:
        random = np.random.default_rng(seed)
        turned = bumpy.vertices @ Rotation.random(random_state=random).as_matrix().T
        moved = 10 ** random.uniform(-3, 3) * (turned + random.normal(0, 5, 3))
        order = random.permutation(len(moved))
        mesh = sg.Mesh(moved[order], np.argsort(order)[bumpy.faces])
        before, after = keypoints(bumpy, detector), keypoints(mesh, detector)
        assert order[after.indices].tolist() == before.indices.tolist()
        assert after.response == pytest.approx(before.response, rel=1e-4)

    def test_points_are_vertices_the_strongest_first(self, bumpy: sg.Mesh, detector: str) -> None:
        found = keypoints(bumpy, detector)
        assert len(found) == len(set(found.indices)) > 0
        assert (np.diff(found.response) <= 0).all()
        assert found.response.min() > 0

    def test_open_and_loose_parts_are_no_trouble(
        self, bumpy: sg.Mesh, shapes: type[Shapes], detector: str
    ) -> None:
        half = bumpy.faces[(bumpy.vertices[bumpy.faces][:, :, 2] > 0).all(axis=1)]
        used, faces = np.unique(half, return_inverse=True)
        sheet = shapes.rectangle(1, 1, 5)
        mesh = sg.Mesh(
            np.concatenate([bumpy.vertices[used], sheet.vertices + 4]),
            np.concatenate([faces.reshape(-1, 3), sheet.faces + len(used)]),
        )
        found = keypoints(mesh, detector)
        assert np.isfinite(found.response).all()

    def test_a_coarse_mesh_has_an_answer(self, detector: str) -> None:
        box = trimesh.creation.box()
        assert len(keypoints(sg.Mesh(box.vertices, box.faces), detector)) <= 8


class TestRefusals:
    def test_unknown_names_and_values(self, bumpy: sg.Mesh) -> None:
        spectrum = sg.compute_spectrum(bumpy, 10)
        with pytest.raises(ValueError, match="detector must be one of hks-maxima, mesh-dog"):
            detect_keypoints(bumpy, spectrum, "sift")
        with pytest.raises(ValueError, match="no parameter 'radius'; it has time, persistence"):
            detect_keypoints(bumpy, spectrum, "hks-maxima", radius=1.0)
        with pytest.raises(ValueError, match="time of 'hks-maxima' must be a positive number, not -1"):
            detect_keypoints(bumpy, spectrum, "hks-maxima", time=-1.0)
        with pytest.raises(ValueError, match=r"largest=0\.1 must not be below smallest=0\.2"):
            detect_keypoints(bumpy, spectrum, "mesh-dog", smallest=0.2, largest=0.1)

    def test_a_spectrum_of_another_mesh(self, bumpy: sg.Mesh, shapes: type[Shapes]) -> None:
        spectrum = sg.compute_spectrum(shapes.sphere(2), 10)
        with pytest.raises(sg.MeshError, match=r"bumpy sphere.*spectrum of that mesh"):
            detect_keypoints(bumpy, spectrum)
