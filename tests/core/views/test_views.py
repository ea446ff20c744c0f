# SPDX-License-Identifier: MIT
"""Views of shapes: what they do not depend on, what they tell apart, and input in any state."""

from __future__ import annotations

from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import binary_dilation, binary_erosion
from scipy.spatial.transform import Rotation

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import Mesh, as_mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.views import (
    CODE_BYTES,
    VIEW_ROTATIONS,
    ShapeViews,
    ViewModel,
    learn_views,
    normal_pictures,
    surface_points,
    symmetries,
)
from shapegoogle_core.views.histograms import gradient_histograms
from shapegoogle_core.views.network import network_features, read_network
from shapegoogle_core.views.points import fit_into_ball
from shapegoogle_core.views.poses import straight_axes
from shapegoogle_core.views.view_model import shape_pictures
from tests.core.conftest import make_bumpy
from tests.core.views.conftest import make_boxes


def distance(views: ViewModel, first: Mesh, second: Mesh) -> float:
    (found,) = views.distances(views.describe(first), views.describe(second).descriptors[None])
    return float(found)


# -- what views do not depend on ----------------------------------------------------------------------------


def test_the_same_file_gives_the_same_bytes(views: ViewModel, chair: Mesh) -> None:
    first, second = views.describe(chair), views.describe(Mesh(chair.vertices, chair.faces))
    assert first.to_bytes() == second.to_bytes()
    assert len(first.to_bytes()) <= 4_000
    assert views.code(first).tolist() == views.code(second).tolist()
    assert views.code(first).shape == (CODE_BYTES,)


@pytest.mark.parametrize("scale", [1e-200, 1e-6, 3.0, 1e12, 1e300])
def test_size_and_place_do_not_count(views: ViewModel, chair: Mesh, scale: float) -> None:
    moved = Mesh((chair.vertices + np.array([3.0, -2.0, 1.0])) * scale, chair.faces)
    assert distance(views, chair, moved) < 0.02


@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 10_000), mirrored=st.booleans())
def test_turned_and_mirrored_shapes_look_alike(
    views: ViewModel, chair: Mesh, table: Mesh, seed: int, mirrored: bool
) -> None:
    turn = Rotation.random(random_state=seed).as_matrix() * (-1 if mirrored else 1)
    moved = Mesh(chair.vertices @ turn.T, chair.faces)
    assert distance(views, chair, moved) < 0.15 < 0.4 < distance(views, table, moved)


def test_other_orders_of_vertices_and_faces(views: ViewModel, chair: Mesh) -> None:
    random = np.random.default_rng(5)
    order = random.permutation(len(chair.vertices))
    place = np.argsort(order)
    faces = np.stack([np.roll(face, random.integers(3)) for face in place[chair.faces]])
    shuffled = Mesh(chair.vertices[order], random.permutation(faces))
    flipped = Mesh(chair.vertices, chair.faces[:, ::-1])
    # Other points are drawn, which shows at edges; unlike shapes are at 0.5 and more.
    assert distance(views, chair, shuffled) < 0.15
    assert distance(views, chair, flipped) < 0.15


def test_other_triangulations(views: ViewModel, chair: Mesh) -> None:
    finer = trimesh.Trimesh(chair.vertices, chair.faces).subdivide().subdivide()
    assert distance(views, chair, as_mesh(finer)) < 0.15


def test_distances_are_symmetric(views: ViewModel, chair: Mesh, table: Mesh) -> None:
    described = [views.describe(mesh) for mesh in (chair, table, make_bumpy(2))]
    stored = np.stack([each.descriptors for each in described])
    distances = np.stack([views.distances(each, stored) for each in described])
    np.testing.assert_allclose(distances, distances.T, atol=1e-5)
    np.testing.assert_allclose(np.diag(distances), 0, atol=1e-5)
    assert (distances >= 0).all()
    assert (distances <= 2).all()


def test_symmetries_are_what_turned_shapes_show(chair: Mesh) -> None:
    """Exchanged and mirrored pictures are those of the turned shape, up to points between two pixels."""
    points, normals = surface_points(chair, 20_000)
    pictures = normal_pictures(points, normals, 64)
    for symmetry in symmetries()[::5]:
        turned = normal_pictures(points @ symmetry.matrix.T, normals @ symmetry.matrix.T, 64)
        expected = pictures[symmetry.pictures].copy()
        for picture, (across, over) in zip(expected, symmetry.mirrored, strict=True):
            if across:
                picture[:] = picture[:, ::-1] * [-1, 1, 1]
            if over:
                picture[:] = picture[::-1] * [1, -1, 1]
        differ = np.abs(turned - expected).max(axis=-1) > 1e-3
        assert differ.mean() < 0.01


def test_components_change_signs_like_the_pictures(views: ViewModel, chair: Mesh) -> None:
    """The code of a flipped shape is one of the alternatives of the shape's code, but for a few bits."""
    code = views.code(views.describe(chair))
    straight, principal = views.code_alternatives(code)
    assert straight[0].tolist() == code[:32].tolist()
    flipped = views.code(views.describe(Mesh(chair.vertices * [-1, -1, 1], chair.faces)))
    apart = np.unpackbits(principal ^ flipped[32:], axis=1).sum(axis=1)
    assert apart.min() < 40 < apart.max()


@pytest.mark.parametrize("turn", [(90, 0, 0), (0, 0, 90), (30, 40, 50), (180, 20, 0)])
def test_straight_axes_of_a_turned_chair_are_its_own(chair: Mesh, turn: tuple[float, float, float]) -> None:
    points, normals = surface_points(chair, 20_000)
    assert straight_axes(points, normals).tolist() == np.eye(3).tolist()
    rotation = Rotation.from_euler("xyz", turn, degrees=True).as_matrix()
    axes = straight_axes(points @ rotation.T, normals @ rotation.T) @ rotation
    np.testing.assert_allclose(np.sort(np.abs(axes), axis=1), [[0, 0, 1]] * 3, atol=0.01)
    assert np.linalg.det(axes) == pytest.approx(1)


def test_a_round_shape_keeps_the_axes_of_its_file() -> None:
    points, normals = surface_points(make_bumpy(3), 20_000)
    assert straight_axes(points, normals).tolist() == np.eye(3).tolist()


# -- shapes in any state ------------------------------------------------------------------------------------

BAD = {
    "one triangle": Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    "degenerate": Mesh(np.diag([0, 1, 2]) @ np.ones((3, 3)), [[0, 1, 2], [0, 0, 1]]),
    "one point": Mesh(np.ones((3, 3)), [[0, 1, 2]]),
    "no vertices": Mesh(np.empty((0, 3))),
    "three faces at an edge": Mesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]]
    ),
    "a cloud of one point": Mesh([[5.0, 5.0, 5.0]]),
    "a cloud of equal points": Mesh(np.ones((50, 3))),
    "a line of points": Mesh(np.linspace([0, 0, 0], [1, 0, 0], 30)),
    "huge and tiny": Mesh(
        np.array([[0.0, 0, 0], [1e308, 0, 0], [0, 1e-308, 0], [-1e308, 1e308, 0]]), [[0, 1, 2], [1, 2, 3]]
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_any_shape_can_be_described(views: ViewModel, name: str) -> None:
    with np.errstate(all="raise", under="ignore"):
        described = views.describe(BAD[name])
        distances = views.distances(described, described.descriptors[None])
    assert described.descriptors.shape == views.shape
    assert np.isfinite(distances).all()


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 40))
def test_soup(views: ViewModel, seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    vertices = random.standard_normal((12, 3)) * 10.0 ** random.integers(-3, 3, 3)
    soup = Mesh(vertices, random.integers(0, 12, (count, 3)))
    described = views.describe(soup)
    assert described.to_bytes() == views.describe(soup).to_bytes()
    assert views.distances(described, described.descriptors[None]) == pytest.approx([0], abs=1e-5)


def test_a_stray_vertex_does_not_shrink_the_pictures(views: ViewModel, chair: Mesh) -> None:
    stray = Mesh(np.append(chair.vertices, [[1e6, 0, 0]], axis=0), chair.faces)
    assert distance(views, chair, stray) < 1e-6


def test_a_point_cloud_looks_like_its_surface(views: ViewModel, table: Mesh, chair: Mesh) -> None:
    scan = trimesh.Trimesh(chair.vertices, chair.faces).sample(5_000, seed=3)
    cloud = Mesh(np.asarray(scan))
    assert distance(views, chair, cloud) < 0.5 * distance(views, table, cloud)


# -- pictures and points ------------------------------------------------------------------------------------


def test_a_sphere_faces_every_viewer() -> None:
    points, normals = surface_points(trimesh.creation.icosphere(4), 40_000)
    pictures = normal_pictures(points, normals, 32)
    seen = pictures.any(axis=-1)
    np.testing.assert_allclose(np.linalg.norm(pictures[seen], axis=1), 1, atol=1e-4)
    assert (pictures[..., 2] >= 0).all()
    middle = (np.arange(32) + 0.5) / 16 - 1
    across, up = np.meshgrid(middle, -middle)
    inner = across**2 + up**2 < 0.8
    for picture in pictures:
        assert np.abs(picture[..., 0] - across)[inner].max() < 0.1
        assert np.abs(picture[..., 1] - up)[inner].max() < 0.1


SOLIDS = {
    "ball": as_mesh(trimesh.creation.icosphere(2)),
    "box": as_mesh(trimesh.creation.box((1, 2, 3))),
    "grid": make_boxes(
        [((0.06, 1.0, 0.03), (0.15 * bar, 0.0, 0.0)) for bar in range(-3, 4)]
        + [((1.0, 0.06, 0.03), (0.0, 0.15 * bar, 0.0)) for bar in range(-3, 4)],
        "grid",
    ),
}


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("number", [0, 6])
def test_pictures_have_no_holes_and_keep_gaps(name: str, number: int) -> None:
    points, normals = surface_points(SOLIDS[name], 30_000)
    picture = normal_pictures(points, normals, 128)[number]
    exact = _drawn_exactly(SOLIDS[name], VIEW_ROTATIONS[number], 128)
    seen, solid = np.asarray(picture.any(axis=-1)), np.asarray(exact.any(axis=-1))
    inner = np.asarray(binary_erosion(solid, np.ones((3, 3), bool)))
    assert not (inner & ~seen).any()
    assert (solid & ~seen).sum() <= 3
    # Points are drawn into every pixel that they touch: half a pixel more along the outline.
    assert not (seen & ~np.asarray(binary_dilation(solid, np.ones((3, 3), bool)))).any()
    if name == "grid":
        assert (~seen[32:96, 32:96]).mean() > 0.1
    # Where a bar or a face ends, the pixel may show one or the other.
    apart = np.abs(picture - exact).max(axis=-1)[inner]
    assert (apart > 0.3).mean() < (0.15 if name == "grid" else 0.01)


def _drawn_exactly(mesh: Mesh, frame: FloatArray, size: int) -> FloatArray:
    """Normals of the nearest faces that the rays through the middles of the pixels hit, face by face."""
    corners = (fit_into_ball(mesh.vertices) @ frame.T)[mesh.faces]
    middle = (2 * np.arange(size) + 1) / size - 1
    across, up = np.meshgrid(middle, -middle)
    picture, nearest = np.zeros((size, size, 3)), np.full((size, size), -np.inf)
    for a, b, c in corners:
        normal = np.cross(b - a, c - a)
        if abs(normal[2]) < 1e-12:
            continue
        one = ((across - a[0]) * (c - a)[1] - (up - a[1]) * (c - a)[0]) / normal[2]
        two = ((b - a)[0] * (up - a[1]) - (b - a)[1] * (across - a[0])) / normal[2]
        depth = a[2] + one * (b - a)[2] + two * (c - a)[2]
        hit = (one >= 0) & (two >= 0) & (one + two <= 1) & (depth > nearest)
        nearest[hit] = depth[hit]
        picture[hit] = normal / np.linalg.norm(normal) * np.sign(normal[2])
    return picture


def test_pictures_of_nothing_are_empty() -> None:
    assert not normal_pictures(np.empty((0, 3)), np.empty((0, 3)), 16).any()


def test_points_lie_on_the_surface_in_proportion_to_its_area() -> None:
    points, normals = surface_points(trimesh.creation.box((1, 1, 4)), 9_000)
    assert np.linalg.norm(points, axis=1).max() <= 1 + 1e-6
    top = np.isclose(np.abs(normals[:, 2]), 1)
    assert top.mean() == pytest.approx(2 / 18, abs=0.001)
    np.testing.assert_allclose(np.abs(points[top, 2]), 4 / np.sqrt(18), atol=1e-6)


def test_an_even_picture_has_no_gradients() -> None:
    histograms = gradient_histograms(np.zeros((2, 64, 64, 3), np.float32))
    assert histograms.shape == (2, 2304)
    assert not histograms.any()


# -- learning, and models that do not fit -------------------------------------------------------------------


def test_learning_needs_enough_pictures(chair: Mesh) -> None:
    with pytest.raises(ValueError, match="24 pictures are too few to learn 192 components of gradients from"):
        learn_views([chair])


def test_learnt_from_the_same_shapes_it_is_the_same(chair: Mesh, table: Mesh) -> None:
    first, second = (learn_views([chair, table], components=(24, 12)) for _ in range(2))
    assert first.identifier == second.identifier
    assert first.shape == (2, 12 * 24 + 6 * 12)


def test_views_of_another_model_cannot_be_compared(views: ViewModel, chair: Mesh) -> None:
    described = views.describe(chair)
    with pytest.raises(ModelError, match="describe all shapes with this model"):
        views.distances(ShapeViews(described.descriptors, "another"), described.descriptors[None])
    with pytest.raises(ModelError, match="describe all shapes with this model"):
        views.distances(described, described.descriptors)


def test_damaged_views_are_refused(views: ViewModel) -> None:
    own, network = views.gradients, views.network
    assert network is not None
    with pytest.raises(ModelError, match="views are damaged"):
        replace(own, mean=own.mean[1:])
    with pytest.raises(ModelError, match="views are damaged"):
        replace(own, mean=np.full_like(own.mean, np.nan))
    with pytest.raises(ModelError, match="views are damaged"):
        replace(network, projection=network.projection[1:])


def test_views_of_an_earlier_model_have_no_network(views: ViewModel, chair: Mesh, table: Mesh) -> None:
    earlier = ViewModel(views.gradients)
    described = earlier.describe(chair)
    stored = np.stack([described.descriptors, earlier.describe(table).descriptors])
    same, other = earlier.distances(described, stored)
    assert same == pytest.approx(0, abs=1e-5)
    assert other > 0.3
    assert earlier.identifier != views.identifier
    with pytest.raises(ModelError, match="describe all shapes with this model"):
        views.distances(described, stored)


# -- the network --------------------------------------------------------------------------------------------


def test_features_do_not_depend_on_the_number_of_threads(chair: Mesh) -> None:
    """One thread is what the product uses; the network's own file gives the same in four."""
    import onnxruntime

    pictures = shape_pictures(chair)[0, :3]
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 4
    file = resources.files("shapegoogle_core") / "views" / "shipped" / "efficientnet_lite0.onnx"
    session = onnxruntime.InferenceSession(file.read_bytes(), options, providers=["CPUExecutionProvider"])
    white = np.where(pictures.any(axis=3, keepdims=True), pictures, np.float32(1))
    (expected,) = session.run(None, {"pictures": np.ascontiguousarray(white.transpose(0, 3, 1, 2))})
    np.testing.assert_allclose(network_features(pictures) ** 2, expected, rtol=1e-4, atol=1e-4)


def test_features_of_a_picture_do_not_depend_on_the_others(chair: Mesh) -> None:
    pictures = shape_pictures(chair)[0, :4]
    alone = np.concatenate([network_features(picture[None]) for picture in pictures])
    np.testing.assert_allclose(network_features(pictures), alone, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("state", ["missing", "damaged"])
def test_a_network_that_cannot_be_read_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, state: str
) -> None:
    folder = tmp_path / "views" / "shipped"
    folder.mkdir(parents=True)
    whole = resources.files("shapegoogle_core") / "views" / "shipped" / "efficientnet_lite0.onnx"
    if state == "damaged":
        (folder / "efficientnet_lite0.onnx").write_bytes(whole.read_bytes()[:-100])
    monkeypatch.setattr("shapegoogle_core.views.network.resources.files", lambda _: tmp_path)
    said = {"missing": "cannot read .*: No such file or directory", "damaged": "is damaged"}[state]
    with pytest.raises(ModelError, match=f"(?s){said}; install Shape Google again"):
        read_network()


def test_another_network_is_refused(views: ViewModel, chair: Mesh) -> None:
    assert views.network is not None
    other = replace(views, network=replace(views.network, digest="0123456789abcdef"))
    with pytest.raises(ModelError, match="learnt with another network"):
        other.describe(chair)
