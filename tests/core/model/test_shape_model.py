# SPDX-License-Identifier: MIT
"""The model: invariances of a signature, distances and similarities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_info, threadpool_limits

from shapegoogle_core.errors import MeshError, ModelError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, load_model, shape_model
from tests.core.conftest import Shapes

# Relative L1 change of the bags that each invariance may cost, with the default model.
RIGID_BOUND = 1e-3
ORDER_BOUND = 1e-3
REFINEMENT_BOUND = 0.03


@pytest.fixture(scope="module")
def model() -> ShapeModel:
    return load_model()


def change(model: ShapeModel, first: Mesh, second: Mesh) -> float:
    a, b = model.describe(first).bags, model.describe(second).bags
    return float(np.abs(a - b).sum() / np.abs(a).sum())


def split_faces(mesh: Mesh) -> Mesh:
    """Every face cut into four at the midpoints of its edges: the same surface, four times the faces."""
    a, b, c = mesh.faces.T
    midpoints, index = {}, len(mesh.vertices)
    vertices = [*mesh.vertices]

    def midpoint(i: int, j: int) -> int:
        nonlocal index
        key = (min(i, j), max(i, j))
        if key not in midpoints:
            vertices.append((mesh.vertices[i] + mesh.vertices[j]) / 2)
            midpoints[key] = index
            index += 1
        return midpoints[key]

    faces = []
    for i, j, k in zip(a, b, c, strict=True):
        ij, jk, ki = midpoint(i, j), midpoint(j, k), midpoint(k, i)
        faces += [(i, ij, ki), (ij, j, jk), (ki, jk, k), (ij, jk, ki)]
    return Mesh(np.array(vertices), np.array(faces))


@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 10_000), exponent=st.floats(-5, 5), shape=st.integers(0, 3))
def test_rigid_motion_and_size_do_not_change_a_bag(
    seed: int, exponent: float, shape: int, shapes: type[Shapes], model: ShapeModel
) -> None:
    mesh = shapes.bumpy(4, shape)
    random = np.random.default_rng(seed)
    rotation, _ = np.linalg.qr(random.standard_normal((3, 3)))
    moved = Mesh((mesh.vertices @ rotation + random.uniform(-3, 3, 3)) * 10.0**exponent, mesh.faces)
    assert change(model, mesh, moved) < RIGID_BOUND


@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 10_000), shape=st.integers(0, 3))
def test_order_of_vertices_and_faces_does_not_change_a_bag(
    seed: int, shape: int, shapes: type[Shapes], model: ShapeModel
) -> None:
    mesh = shapes.bumpy(4, shape)
    random = np.random.default_rng(seed)
    order = random.permutation(len(mesh.vertices))
    faces = np.argsort(order)[mesh.faces]
    shuffled = Mesh(mesh.vertices[order], faces[random.permutation(len(faces))])
    assert change(model, mesh, shuffled) < ORDER_BOUND


@pytest.mark.parametrize("shape", range(2))
def test_refinement_hardly_changes_a_bag(shape: int, shapes: type[Shapes], model: ShapeModel) -> None:
    mesh = shapes.bumpy(4, shape)  # 2,562 vertices; refined 10,242, above the budget
    refined = change(model, mesh, split_faces(mesh))
    assert refined < REFINEMENT_BOUND
    torus = trimesh.creation.torus(1.0, 0.4)
    assert refined < 0.1 * change(model, mesh, Mesh(torus.vertices, torus.faces))


def test_signature_says_what_was_given(bumpy: Mesh, model: ShapeModel) -> None:
    signature = model.describe(bumpy)
    assert signature.bags.shape == (model.bag_size,)
    assert signature.bags.dtype == np.float32
    assert signature.code.shape == (model.code_bits // 8,)
    assert signature.area == pytest.approx(bumpy.area)
    assert (signature.vertex_count, signature.face_count) == (len(bumpy.vertices), len(bumpy.faces))


def test_code_is_the_sign_of_the_projection(bumpy: Mesh, model: ShapeModel) -> None:
    signature = model.describe(bumpy)
    vector = model.embed(signature.bags[None])[0]
    bits = model.directions @ vector + model.thresholds > 0
    np.testing.assert_array_equal(np.unpackbits(signature.code).astype(bool), bits)


def test_distance_to_itself_is_zero_and_similarity_falls(shapes: type[Shapes], model: ShapeModel) -> None:
    bags = np.array([model.describe(shapes.bumpy(3, seed)).bags for seed in range(3)])
    distances = model.distances(bags[0], bags)
    assert distances[0] == pytest.approx(0, abs=1e-6)
    assert (distances[1:] > 0.01).all()
    grid = np.linspace(0, 2, 50)
    similarity = model.similarity(grid)
    assert similarity[0] == 1
    assert (np.diff(similarity) < 0).all()
    assert similarity[-1] > 0
    assert model.similarity(np.array([model.similarity_half]))[0] == pytest.approx(0.5)


@pytest.mark.parametrize("distance", [1e3, 1e9, 1e200])
def test_a_stray_vertex_changes_nothing(distance: float, bumpy: Mesh, model: ShapeModel) -> None:
    stray = Mesh(np.concatenate([bumpy.vertices, [[distance, 0, 0]]]), bumpy.faces)
    assert change(model, bumpy, stray) < RIGID_BOUND


def test_open_shape_of_several_parts_may_be_moved(shapes: type[Shapes], model: ShapeModel) -> None:
    ball, sheet = shapes.bumpy(3), shapes.rectangle(2.0, 1.0, 20)
    faces = np.concatenate([ball.faces[100:], sheet.faces + len(ball.vertices)])
    parts = Mesh(np.concatenate([ball.vertices, sheet.vertices + 2]), faces)
    rotation, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))
    assert change(model, parts, Mesh(parts.vertices @ rotation * 7, faces)) < RIGID_BOUND


def test_low_poly_props_have_a_signature(model: ShapeModel) -> None:
    box = trimesh.creation.box((1, 2, 3))
    assert np.isfinite(model.describe(Mesh(box.vertices, box.faces)).bags).all()


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((5, 3)), [[0, 1, 2], [2, 3, 4]], "coincide|point"),
        (np.eye(3), [[0, 1, 2]], "4 vertices|3 vertices"),
        (np.random.default_rng(0).standard_normal((9, 3)), None, "no faces"),
        (np.outer(np.arange(6.0), [1, 2, 3]), [[0, 1, 2], [3, 4, 5]], "area|line|surface"),
    ],
)
def test_what_has_no_surface_is_refused_by_name(
    vertices: ArrayLike, faces: ArrayLike | None, message: str, model: ShapeModel
) -> None:
    with pytest.raises(MeshError, match=message) as caught:
        model.describe(Mesh(vertices, faces, name="broken.obj"))
    assert "broken.obj" in str(caught.value)


def test_anything_mesh_like_is_described(model: ShapeModel) -> None:
    box = trimesh.creation.box((1, 2, 3))
    expected = model.describe(Mesh(box.vertices, box.faces)).bags
    for same in (box, (box.vertices, box.faces), (box.vertices.tolist(), box.faces.tolist())):
        np.testing.assert_array_equal(model.describe(same).bags, expected)


def test_what_an_agreement_counts_is_part_of_the_identity(model: ShapeModel) -> None:
    """Otherwise a library would rank by another gain than the model it is asked with."""
    assert replace(model, agreement_gain=model.agreement_gain + 1).identifier != model.identifier


@pytest.mark.parametrize("gain", [-1.0, np.nan, np.inf])
def test_a_damaged_gain_is_refused(model: ShapeModel, gain: float) -> None:
    with pytest.raises(ModelError, match="agreement_gain"):
        replace(model, agreement_gain=gain)


def test_agreement_lowers_the_distance(model: ShapeModel) -> None:
    distances = [model.verified_distance(0.4, excess) for excess in (0, 0.1, 0.5)]
    assert distances[0] == 0.4
    assert distances[0] > distances[1] > distances[2] > 0


def test_a_distance_that_no_agreement_lowered_says_less(model: ShapeModel) -> None:
    """Bags alone, and bags where verification found nothing."""
    distances = np.linspace(0.01, 1.5, 30)
    alone, verified = model.similarity(distances), model.similarity(distances, verified=True)
    for similarities in (alone, verified):
        assert (np.diff(similarities) < 0).all()
        assert ((similarities > 0) & (similarities < 1)).all()
    assert (verified < alone).all()


def test_everything_is_computed_with_one_thread_of_blas(
    model: ShapeModel, bumpy: Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: dict[str, set[int]] = {}

    def watched(name: str) -> Callable[..., Any]:
        function = getattr(shape_model, name)

        def watching(*arguments: Any) -> Any:
            seen[name] = {
                library["num_threads"]
                for library in threadpool_info()
                if library["user_api"] == "blas" and "numpy" in library["filepath"]
            }
            return function(*arguments)

        return watching

    names = ("working_shape", "shape_bags", "sample_surface", "measure_mesh")
    for name in names:
        monkeypatch.setattr(shape_model, name, watched(name))
    with threadpool_limits(2, user_api="blas"):
        model.describe(bumpy)
    assert seen == {name: {1} for name in names}
