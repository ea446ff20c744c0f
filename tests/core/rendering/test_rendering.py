# SPDX-License-Identifier: MIT
"""Pictures without a graphics card: what is drawn where, views, colours."""

from __future__ import annotations

import io

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from scipy.ndimage import binary_fill_holes

from shapegoogle_core import Mesh, MeshError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.rendering import (
    canonical_view,
    look_from,
    render,
    thumbnail,
    value_colors,
    word_palette,
)

FRONT = np.eye(3)


def sphere(subdivisions: int = 3) -> Mesh:
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    return Mesh(ball.vertices, ball.faces, "ball")


def coverage(image: Image.Image) -> FloatArray:
    return np.asarray(np.asarray(image)[:, :, 3] / 255)


class TestRender:
    def test_sphere_covers_a_disc(self) -> None:
        image = render(sphere(), size=(100, 100), background=None, view=FRONT)
        alpha = coverage(image)
        # 4 % margin on each side: a disc of diameter 92.
        assert alpha.sum() == pytest.approx(np.pi * 46**2, rel=0.02)
        y, x = np.mgrid[:100, :100] + 0.5
        assert (alpha[np.hypot(x - 50, y - 50) < 44] == 1).all()
        assert (alpha[np.hypot(x - 50, y - 50) > 47.5] == 0).all()

    @pytest.mark.parametrize("size", [(64, 64), (120, 60), (50, 130), (1, 1)])
    def test_size_and_mode(self, size: tuple[int, int]) -> None:
        assert render(sphere(), size=size).size == size
        assert render(sphere(), size=size).mode == "RGB"
        assert render(sphere(), size=size, background=None).mode == "RGBA"

    def test_background_shows_around_the_shape(self) -> None:
        image = render(sphere(), background=(10, 200, 30), view=FRONT)
        assert image.getpixel((0, 0)) == (10, 200, 30)
        assert image.getpixel((128, 128)) != (10, 200, 30)

    @pytest.mark.parametrize("order", [[0, 1], [1, 0]])
    def test_nearer_faces_hide_farther_ones(self, order: list[int]) -> None:
        # Two crossing squares: each is in front on one half.
        red = np.array([[-1, -1, -1], [1, -1, 1], [1, 1, 1], [-1, 1, -1]], float)
        blue = red * [1, 1, -1]
        squares = [(red, [1, 0, 0]), (blue, [0, 0, 1])]
        vertices = np.concatenate([squares[i][0] for i in order])
        colors = np.repeat([squares[i][1] for i in order], 4, axis=0)
        faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
        image = np.asarray(render(Mesh(vertices, faces), colors, size=(64, 64), view=FRONT)).astype(int)
        assert (image[20:44, 40:56, 0] > image[20:44, 40:56, 2] + 50).all()
        assert (image[20:44, 8:24, 2] > image[20:44, 8:24, 0] + 50).all()

    def test_colors_run_between_vertices(self) -> None:
        square = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
        ramp = np.array([[0, 0, 0], [1, 1, 1], [1, 1, 1], [0, 0, 0]], float)
        row = np.asarray(render(square, ramp, size=(64, 64), view=FRONT))[32, 4:60, 0].astype(int)
        assert (np.diff(row) >= 0).all()
        assert row[0] < 10 < 180 < row[-1]

    def test_right_up_and_handedness(self) -> None:
        # An L: its long leg points up, its short one to the right.
        mesh = trimesh.util.concatenate(
            [
                trimesh.creation.box(bounds=[[0, 0, 0], [1, 4, 1]]),
                trimesh.creation.box(bounds=[[0, 0, 0], [2, 1, 1]]),
            ]
        )
        assert isinstance(mesh, trimesh.Trimesh)
        alpha = coverage(render(Mesh(mesh.vertices, mesh.faces), size=(80, 80), background=None, view=FRONT))
        assert alpha[70, 24:56].all()
        assert alpha[8:72, 26].all()
        assert not alpha[8:50, 45:].any()

    def test_light_comes_from_above_and_left(self) -> None:
        image = np.asarray(render(sphere(), size=(100, 100), view=FRONT)).astype(int).sum(axis=2)
        assert image[25, 35] > image[75, 65]

    def test_closed_surface_has_no_gaps(self) -> None:
        bumpy = sphere(4)
        bumpy = Mesh(bumpy.vertices * (1 + 0.1 * np.sin(7 * bumpy.vertices[:, :1])), bumpy.faces)
        alpha = coverage(render(bumpy, size=(120, 120), background=None))
        np.testing.assert_array_equal(binary_fill_holes(alpha == 1), alpha == 1)

    def test_flipped_faces_look_the_same(self) -> None:
        ball = sphere()
        one, other = render(ball), render(Mesh(ball.vertices, ball.faces[:, ::-1]))
        assert np.abs(np.asarray(one).astype(int) - np.asarray(other)).max() <= 2

    @pytest.mark.parametrize("unit", [1e-12, 1e12])
    def test_unit_does_not_matter(self, unit: float) -> None:
        egg = Mesh(sphere().vertices * [1, 2, 1.5], sphere().faces)
        far = Mesh(egg.vertices * unit + 3 * unit, egg.faces)
        difference = np.abs(np.asarray(render(egg)).astype(int) - np.asarray(render(far)))
        assert np.percentile(difference, 99.9) <= 2

    def test_soup_and_large_triangles(self) -> None:
        rng = np.random.default_rng(0)
        corners = rng.standard_normal((900, 3))
        image = render(Mesh(corners, np.arange(900).reshape(-1, 3)), size=(256, 256), background=None)
        assert coverage(image).mean() > 0.3

    @settings(deadline=None, max_examples=30)
    @given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 12), axes=st.integers(0, 3))
    def test_any_shape_gives_a_picture(self, seed: int, count: int, axes: int) -> None:
        rng = np.random.default_rng(seed)
        # Flat in the last axes, down to a single point.
        vertices = rng.standard_normal((count, 3)) * (np.arange(3) < axes)
        faces = rng.integers(0, count, (rng.integers(0, 8), 3))
        assert render(Mesh(vertices, faces), size=(40, 30)).size == (40, 30)

    def test_point_cloud(self) -> None:
        alpha = coverage(render(Mesh(sphere().vertices), size=(64, 64), background=None, view=FRONT))
        assert alpha[32, 32] > 0
        assert alpha[0, 0] == 0
        assert 0.3 < alpha.mean() < 0.8

    def test_wrong_input_is_refused(self) -> None:
        with pytest.raises(MeshError, match="'nothing' has no vertices"):
            render(Mesh(np.empty((0, 3)), name="nothing"))
        with pytest.raises(ValueError, match=r"'ball': colors must have shape \(3,\) or \(642, 3\)"):
            render(sphere(), np.zeros((5, 3)))
        with pytest.raises(ValueError, match="colors must be between 0 and 1"):
            render(sphere(), [255, 0, 0])
        with pytest.raises(ValueError, match="positive size"):
            render(sphere(), size=(0, 10))


class TestThumbnail:
    def test_is_a_small_transparent_png(self) -> None:
        data = thumbnail(sphere(), 128)
        image = Image.open(io.BytesIO(data))
        assert image.format == "PNG"
        assert image.size == (128, 128)
        alpha = image.convert("RGBA").getchannel("A")
        assert (alpha.getpixel((0, 0)), alpha.getpixel((64, 64))) == (0, 255)
        assert 500 < len(data) < 8000

    def test_is_reproducible(self) -> None:
        assert thumbnail(sphere()) == thumbnail(sphere())


class TestViews:
    @settings(deadline=None, max_examples=30)
    @given(seed=st.integers(0, 2**32 - 1))
    def test_look_from_is_a_rotation(self, seed: int) -> None:
        direction, up = np.random.default_rng(seed).standard_normal((2, 3))
        view = look_from(direction, up)
        np.testing.assert_allclose(view @ view.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(view) == pytest.approx(1)
        np.testing.assert_allclose(view[2], direction / np.linalg.norm(direction))
        assert view[1] @ up > 0

    def test_parallel_direction_and_up(self) -> None:
        with pytest.raises(ValueError, match="parallel"):
            look_from([0, 0, 2], [0, 0, -1])

    @pytest.mark.parametrize("up", [1, 2], ids=["y up", "z up"])
    def test_a_standing_figure_stands(self, up: int) -> None:
        # A person: tall, broad, thin from front to back, with feet.
        extents = np.array([0.5, 0.2, 0.2])
        extents[up] = 1.8
        body = trimesh.creation.box(extents=extents).subdivide().subdivide()
        view = canonical_view(Mesh(body.vertices, body.faces))
        assert view[1, up] > 0.9

    @pytest.mark.parametrize("up", [1, 2], ids=["y up", "z up"])
    def test_a_table_stands_on_its_legs(self, up: int) -> None:
        parts = [trimesh.creation.box(bounds=[[-1, -0.4, 0.9], [1, 0.4, 1.0]])]
        for x in (-0.9, 0.85):
            for y in (-0.35, 0.3):
                parts.append(trimesh.creation.box(bounds=[[x, y, 0], [x + 0.05, y + 0.05, 0.9]]))
        table = trimesh.util.concatenate([part.subdivide().subdivide().subdivide() for part in parts])
        assert isinstance(table, trimesh.Trimesh)
        vertices = table.vertices if up == 2 else table.vertices[:, [0, 2, 1]] * [1, 1, -1]
        view = canonical_view(Mesh(vertices, table.faces))
        assert view[1, up] > 0.9

    def test_like_shapes_look_the_same_way(self) -> None:
        rng = np.random.default_rng(0)
        horse = trimesh.creation.box(extents=[0.4, 2, 1]).subdivide().subdivide().subdivide()
        views = [
            canonical_view(
                Mesh(horse.vertices + 0.01 * rng.standard_normal(horse.vertices.shape), horse.faces)
            )
            for _ in range(10)
        ]
        for view in views[1:]:
            np.testing.assert_allclose(view, views[0], atol=0.1)


class TestColors:
    def test_words_keep_their_colors(self) -> None:
        large = word_palette(64)
        assert large.shape == (64, 3)
        assert ((large >= 0) & (large <= 1)).all()
        np.testing.assert_array_equal(word_palette(10), large[:10])
        assert word_palette(0).shape == (0, 3)

    def test_words_are_told_apart(self) -> None:
        colors = word_palette(64)
        distances = np.linalg.norm(colors[:, None] - colors[None], axis=2) + 9 * np.eye(64)
        assert distances.min() > 0.05
        assert distances[:12, :12].min() > 0.2

    def test_values_rise_in_lightness(self) -> None:
        colors = value_colors(np.linspace(3, 9, 100))
        luminance = colors @ [0.2126, 0.7152, 0.0722]
        assert (np.diff(luminance) > 0).all()
        steps = np.linalg.norm(np.diff(colors, axis=0), axis=1)
        assert steps.max() < 4 * steps.min()

    def test_range_of_values(self) -> None:
        np.testing.assert_array_equal(value_colors([0, 5, 10, 20], 5, 10)[[0, 3]], value_colors([5, 10]))
        assert len(np.unique(value_colors([2, 2, 2]), axis=0)) == 1
        assert value_colors([]).shape == (0, 3)

    def test_wrong_values(self) -> None:
        with pytest.raises(ValueError, match="1 of 2 values are NaN or infinite"):
            value_colors([1, np.nan])
        with pytest.raises(ValueError, match=r"shape \(n,\), not \(2, 2\)"):
            value_colors(np.eye(2))
        with pytest.raises(ValueError, match="not -1"):
            word_palette(-1)


@pytest.mark.parametrize("up_axis", [1, 2])
def test_what_is_up_can_be_told(up_axis: int) -> None:
    """A cone on its tip, whose base is no sign of what is up."""
    cone = trimesh.creation.cone(radius=1, height=2)
    vertices = cone.vertices * [1, 1, -1]
    if up_axis == 1:
        vertices = vertices[:, [0, 2, 1]]
    view = canonical_view(Mesh(vertices, cone.faces), up_axis)
    assert view[1, up_axis] > 0.9
