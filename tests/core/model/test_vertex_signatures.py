# SPDX-License-Identifier: MIT
"""Spectra, words and keypoints of unclean and of large meshes, at their own vertices."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.shape_bags import channel_words
from shapegoogle_core.model.vertex_signatures import SPOT_RADIUS
from shapegoogle_core.model.working_shape import working_shape
from tests.core.conftest import Shapes


def unwelded(mesh: sg.Mesh) -> sg.Mesh:
    """Every face on its own, as in an STL file."""
    return sg.Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3))


class TestVertexSpectrum:
    def test_is_exact_on_a_clean_mesh(self, bumpy: Mesh) -> None:
        carried = sg.vertex_spectrum(bumpy, 30)
        spectrum = sg.compute_spectrum(bumpy, 30)
        expected = sg.heat_kernel_signature(spectrum, [0.1, 1])
        assert np.array_equal(carried.carry(sg.heat_kernel_signature(carried.spectrum, [0.1, 1])), expected)
        assert not carried.simplified
        assert carried.nearest(7) == 7

    def test_heat_crosses_seams_and_loose_vertices_stay_cold(self, bumpy: Mesh) -> None:
        soup = unwelded(bumpy)
        soup = sg.Mesh(np.concatenate([[[9, 9, 9]], soup.vertices]), soup.faces + 1)
        carried = sg.vertex_spectrum(soup, 30)
        values = carried.carry(sg.heat_kernel_signature(carried.spectrum, [0.1]))[:, 0]
        expected = sg.heat_kernel_signature(sg.compute_spectrum(bumpy, 30), [0.1])[:, 0]
        assert values[0] == 0
        assert carried.nearest(0) is None
        assert np.allclose(values[1:], expected[bumpy.faces.ravel()], rtol=1e-9)

    def test_vertex_of_a_flat_face_only_takes_its_surroundings(self, bumpy: Mesh) -> None:
        a, b = bumpy.faces[0, :2]
        middle = bumpy.vertices[[a, b]].mean(axis=0)
        mesh = sg.Mesh(
            np.concatenate([bumpy.vertices, [middle]]),
            np.concatenate([bumpy.faces, [[a, b, len(bumpy.vertices)]]]),
        )
        carried = sg.vertex_spectrum(mesh, 30)
        values = carried.carry(sg.heat_kernel_signature(carried.spectrum, [0.1]))[:, 0]
        assert values[-1] == pytest.approx((values[a] + values[b]) / 2)

    def test_simplified_copy_is_close(self, shapes: type[Shapes]) -> None:
        mesh = shapes.bumpy(5)
        exact = sg.heat_kernel_signature(sg.compute_spectrum(mesh, 60), [0.2, 2])
        carried = sg.vertex_spectrum(mesh, 60, budget=4000)
        values = carried.carry(sg.heat_kernel_signature(carried.spectrum, [0.2, 2]))
        assert carried.simplified
        assert values.shape == exact.shape
        assert np.abs(values / exact - 1).max() < 0.03

    def test_anything_mesh_like_has_one(self, bumpy: Mesh) -> None:
        expected = sg.vertex_spectrum(bumpy, k=10).spectrum.eigenvalues
        for same in (
            (bumpy.vertices, bumpy.faces),
            trimesh.Trimesh(bumpy.vertices, bumpy.faces, process=False),
        ):
            np.testing.assert_array_equal(sg.vertex_spectrum(same, k=10).spectrum.eigenvalues, expected)

    @pytest.mark.parametrize("faces", [[], [[0, 0, 1]]])
    def test_without_surface_it_says_so(self, faces: list[list[int]]) -> None:
        with pytest.raises(sg.MeshError, match="'rod'"):
            sg.vertex_spectrum(sg.Mesh(np.eye(4, 3), faces, "rod"))


@pytest.fixture(scope="module")
def model() -> ShapeModel:
    return sg.load_model()


class TestVertexWords:
    def test_are_the_words_of_the_model(self, model: ShapeModel, bumpy: Mesh) -> None:
        words = sg.vertex_words(model, bumpy)
        shape = working_shape(model.settings, bumpy)
        expected = channel_words(model.settings, 0, model.vocabularies[0], shape)
        assert np.allclose(words.words, expected)
        assert words.prolongation.shape == (len(bumpy.vertices), len(shape.mesh.vertices))
        weights = words.weights()
        assert weights.shape == (len(bumpy.vertices), model.settings.channels[0].words)
        assert np.allclose(weights.sum(axis=1), 1)
        assert np.array_equal(words.heaviest, weights.argmax(axis=1))
        assert words.bag.sum() == pytest.approx(1)

    @pytest.mark.parametrize("channel", [0, 1, 2])
    def test_do_not_depend_on_place_and_size(self, model: ShapeModel, bumpy: Mesh, channel: int) -> None:
        moved = sg.Mesh(bumpy.vertices[:, [1, 2, 0]] * 250 + [1e3, 0, 0], bumpy.faces)
        here, there = (sg.vertex_words(model, mesh, channel) for mesh in (bumpy, moved))
        assert np.allclose(here.weights(), there.weights(), atol=1e-3)
        assert np.allclose(here.bag, there.bag, atol=1e-3)

    def test_few_words_and_loose_vertices(self, model: ShapeModel, bumpy: Mesh) -> None:
        mesh = sg.Mesh(np.concatenate([bumpy.vertices, [[9, 9, 9]]]), bumpy.faces)
        words = sg.vertex_words(model, mesh)
        few = words.weights(np.array([3, 1]))
        assert np.allclose(few, words.weights()[:, [3, 1]])
        assert few[-1].tolist() == [0, 0]
        assert words.heaviest[-1] == -1


@pytest.fixture(scope="module")
def horse() -> Mesh:
    return make_creature("horse", 120, 1500).pose("rest")


class TestVertexKeypoints:
    @pytest.mark.parametrize("detector", DETECTORS)
    def test_are_those_of_the_mesh_where_it_is_clean(self, horse: Mesh, detector: str) -> None:
        found = sg.vertex_keypoints(horse, detector, k=60)
        expected = sg.detect_keypoints(horse, sg.compute_spectrum(horse, 60), detector)
        assert len(found) > 3
        assert np.array_equal(found.indices, expected.indices)
        assert np.array_equal(found.response, expected.response)
        assert not found.simplified
        assert np.array_equal(np.flatnonzero(found.responses), np.sort(expected.indices))

    def test_come_back_to_vertices_of_an_unclean_mesh_in_their_place(self, horse: Mesh) -> None:
        soup = unwelded(horse)
        mesh = sg.Mesh(np.concatenate([[[9, 9, 9]], soup.vertices]), soup.faces + 1)
        found = sg.vertex_keypoints(mesh)
        expected = sg.vertex_keypoints(horse)
        # The same places, in the same order; a loose vertex is none, wherever it is.
        assert np.array_equal(mesh.vertices[found.indices], horse.vertices[expected.indices])
        assert found.responses.shape == (len(mesh.vertices),)

    def test_a_simplified_copy_has_them_at_the_same_tips(self) -> None:
        mesh = make_creature("horse", 120, 8000).pose("rest")
        exact, near = (sg.vertex_keypoints(mesh, k=60, budget=budget) for budget in (None, 2000))
        assert near.simplified
        assert len(near) == len(exact)
        distances = np.linalg.norm(
            mesh.vertices[near.indices, None] - mesh.vertices[exact.indices], axis=2
        ).min(axis=0)
        assert distances.max() < 0.05 * np.sqrt(mesh.area)
        assert (np.diff(near.response) <= 0).all()

    def test_spots_lie_around_them(self, horse: Mesh) -> None:
        found = sg.vertex_keypoints(horse)
        assert (found.coverage[found.indices] == 1).all()
        assert found.strength[found.indices[0]] == 1
        away = np.linalg.norm(horse.vertices[:, None] - horse.vertices[found.indices], axis=2).min(axis=1)
        assert (away[found.coverage > 0] < SPOT_RADIUS * np.sqrt(horse.area)).all()
        assert (found.strength[found.coverage == 0] == 0).all()

    def test_where_nothing_stands_out_there_are_none(self) -> None:
        sphere = trimesh.creation.icosphere(3)
        sphere = sg.Mesh(sphere.vertices, sphere.faces, "ball")
        found = sg.vertex_keypoints(sphere, "hks-maxima", k=60)
        assert len(found) == 0
        assert not found.coverage.any()
        assert not found.responses.any()

    def test_wrong_detector_and_no_surface(self, horse: Mesh) -> None:
        with pytest.raises(ValueError, match="detector must be one of"):
            sg.vertex_keypoints(horse, "corners", k=5)
        with pytest.raises(sg.MeshError, match="'rod'"):
            sg.vertex_keypoints(sg.Mesh(np.eye(4, 3), [], "rod"))


def test_arguments_out_of_range(model: ShapeModel, bumpy: Mesh) -> None:
    with pytest.raises(ValueError, match="budget must be a whole number of at least 4, not 0"):
        sg.vertex_spectrum(bumpy, budget=0)
    with pytest.raises(ValueError, match=r"k must be a whole number of at least 1, not 1\.5"):
        sg.vertex_spectrum(bumpy, k=1.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="channel must be from 0 to 2, not 5"):
        sg.vertex_words(model, bumpy, channel=5)
    with pytest.raises(sg.ModelError, match=r"bags of this model have 2700 values, .* query are \(3,\)"):
        model.distances(np.zeros(3), np.zeros((2, 2700)))
