# SPDX-License-Identifier: MIT
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings
from hypothesis import strategies as st

from shapegoogle_core import Mesh, MeshError
from shapegoogle_core.mesh import face_areas, unique_edges
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, bend, edge_length_changes, transform

seeds = st.integers(0, 2**32 - 1)
strengths = st.integers(1, 5)


def torus(
    major: float = 3.0, minor: float = 1.0, around: int = 60, along: int = 30, name: str = "torus"
) -> Mesh:
    u, v = np.meshgrid(
        np.linspace(0, 2 * np.pi, around, endpoint=False),
        np.linspace(0, 2 * np.pi, along, endpoint=False),
        indexing="ij",
    )
    ring = major + minor * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), minor * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(along), indexing="ij")
    a, b = i * along + j, (i + 1) % around * along + j
    c, d = (i + 1) % around * along + (j + 1) % along, i * along + (j + 1) % along
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return Mesh(vertices, faces, name)


def soup(mesh: Mesh) -> Mesh:
    """Every triangle with its own three vertices."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3), "soup")


TORUS = torus()
SOUP = soup(torus(around=40, along=20))
SHAPES = {"torus": TORUS, "soup": SOUP}


def diagonal(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))


def mean_edge(mesh: Mesh) -> float:
    edges, _ = unique_edges(mesh)
    return float(np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1).mean())


def places(vertices: np.ndarray) -> set[bytes]:
    return {row.tobytes() for row in vertices}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("kind", TRANSFORMATIONS)
@settings(deadline=None, max_examples=8)
@given(seed=seeds, strength=strengths)
def test_is_pure_and_reproducible(shape: str, kind: str, seed: int, strength: int) -> None:
    mesh = SHAPES[shape]
    vertices, faces = mesh.vertices.copy(), mesh.faces.copy()
    one, again = transform(mesh, kind, strength, seed), transform(mesh, kind, strength, seed)
    np.testing.assert_array_equal(one.vertices, again.vertices)
    np.testing.assert_array_equal(one.faces, again.faces)
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.faces, faces)
    assert one.name == f"{mesh.name}-{kind}-{strength}"
    assert np.isfinite(one.vertices).all()
    assert one.area > 0


@pytest.mark.parametrize("kind", [kind for kind in TRANSFORMATIONS if kind not in ("scale", "sampling")])
def test_another_seed_gives_another_result(kind: str) -> None:
    one, other = transform(TORUS, kind, 3, 1), transform(TORUS, kind, 3, 2)
    assert one.vertices.shape != other.vertices.shape or not np.allclose(one.vertices, other.vertices)


@pytest.mark.parametrize("kind", TRANSFORMATIONS)
@pytest.mark.parametrize("unit", [2.0**-10, 2.0**10])
def test_unit_does_not_matter(kind: str, unit: float) -> None:
    here = transform(TORUS, kind, 4, 5)
    there = transform(Mesh(TORUS.vertices * unit, TORUS.faces), kind, 4, 5)
    if kind == "sampling":
        # Quadrics are sums of products, whose rounding decides ties among equal edges.
        assert len(there.faces) == len(here.faces)
    else:
        np.testing.assert_array_equal(there.faces, here.faces)
        np.testing.assert_allclose(there.vertices, here.vertices * unit, rtol=1e-6, atol=1e-6 * unit)


@settings(deadline=None, max_examples=20)
@given(seed=seeds)
def test_noise_deviation_is_a_tenth_of_the_edge_per_strength(seed: int) -> None:
    shifts = [transform(TORUS, "noise", strength, seed).vertices - TORUS.vertices for strength in range(1, 6)]
    for strength, shift in enumerate(shifts, start=1):
        # 5400 coordinates: the sample's deviation is within 5 % but for once in 10⁶.
        assert shift.std() == pytest.approx(0.1 * strength * mean_edge(TORUS), rel=0.05)
        np.testing.assert_allclose(shift, strength * shifts[0], atol=1e-12)


@settings(deadline=None, max_examples=20)
@given(seed=seeds, strength=strengths)
def test_shot_noise_moves_its_share_of_vertices_far(seed: int, strength: int) -> None:
    shift = np.linalg.norm(transform(TORUS, "shot_noise", strength, seed).vertices - TORUS.vertices, axis=1)
    assert (shift > 0).sum() == max(1, round(0.002 * strength * len(TORUS.vertices)))
    # The length of three normal numbers is within 6 deviations but for once in 10⁷.
    assert shift.max() < 6 * 4 * mean_edge(TORUS)


@settings(deadline=None, max_examples=20)
@given(seed=seeds, strength=strengths)
def test_micro_holes_take_their_share_of_vertices(seed: int, strength: int) -> None:
    result = transform(TORUS, "micro_holes", strength, seed)
    taken = round(0.005 * strength * len(TORUS.vertices))
    # Three neighbours taken may leave a vertex without faces.
    assert len(TORUS.vertices) - taken - 2 <= len(result.vertices) <= len(TORUS.vertices) - taken
    assert places(result.vertices) <= places(TORUS.vertices)


@pytest.mark.parametrize("kind", ["micro_holes", "holes", "partial"])
@pytest.mark.parametrize("shape", SHAPES)
def test_holes_leave_the_rest_where_it_was(kind: str, shape: str) -> None:
    mesh = SHAPES[shape]
    before = places(np.sort(mesh.vertices[mesh.faces].reshape(len(mesh.faces), 9), axis=1))
    for strength in range(1, 6):
        result = transform(mesh, kind, strength, 11)
        after = places(np.sort(result.vertices[result.faces].reshape(len(result.faces), 9), axis=1))
        assert after < before
        assert len(np.unique(result.faces)) == len(result.vertices)


@pytest.mark.parametrize("kind", ["micro_holes", "holes"])
def test_stronger_holes_contain_the_weaker(kind: str) -> None:
    left = [places(transform(TORUS, kind, strength, 4).vertices) for strength in range(1, 6)]
    for weak, strong in pairwise(left):
        assert strong < weak


@settings(deadline=None, max_examples=15)
@given(seed=seeds, strength=strengths)
def test_holes_are_balls(seed: int, strength: int) -> None:
    result = transform(TORUS, "holes", strength, seed)
    radius = 0.03 * diagonal(TORUS)
    left = places(result.vertices)
    gone = np.array([vertex.tobytes() not in left for vertex in TORUS.vertices])
    assert gone.any()
    # What is gone fits in 2 s balls: one of twice the radius around a lost vertex covers what its ball took.
    lost = TORUS.vertices[gone]
    balls = 0
    while len(lost):
        lost = lost[np.linalg.norm(lost - lost[0], axis=1) > 2 * radius + mean_edge(TORUS)]
        balls += 1
    assert balls <= 2 * strength


@settings(deadline=None, max_examples=15)
@given(seed=seeds, strength=strengths)
def test_topology_welds_the_stated_pairs(seed: int, strength: int) -> None:
    result = transform(TORUS, "topology", strength, seed)
    welds = 3 * strength
    assert len(result.vertices) == len(TORUS.vertices) - welds
    assert len(result.faces) == len(TORUS.faces)
    before, after = places(TORUS.vertices), places(result.vertices)
    assert len(after - before) == welds
    assert len(after & before) == len(TORUS.vertices) - 2 * welds


def test_topology_welds_what_is_near_in_space_and_far_along_the_surface() -> None:
    # Two long plates, one under the other, joined at one end: the way round is long.
    x = np.linspace(0, 10, 101)
    profile = np.concatenate(
        [np.stack([x, np.full(101, 0.2)], 1), np.stack([x[::-1], np.full(101, -0.2)], 1)]
    )
    y = np.linspace(0, 2, 21)
    vertices = np.concatenate([np.column_stack([profile, np.full(len(profile), depth)]) for depth in y])
    i, j = np.meshgrid(np.arange(20), np.arange(201), indexing="ij")
    a = i * 202 + j
    faces = np.concatenate(
        [np.stack([a, a + 1, a + 203], -1).reshape(-1, 3), np.stack([a, a + 203, a + 202], -1).reshape(-1, 3)]
    )
    result = transform(Mesh(vertices, faces), "topology", 5, 3)
    before = places(vertices)
    new = np.array([vertex for vertex in result.vertices if vertex.tobytes() not in before])
    assert len(new) == 15
    # Every weld joins the plates, in the middle between them, away from the joint.
    np.testing.assert_allclose(new[:, 1], 0, atol=1e-12)
    assert (new[:, 0] < 10 - 0.4 * 0.35 * 10).all()


def test_topology_of_soup_joins_corners_of_all_faces_there() -> None:
    result = transform(SOUP, "topology", 2, 1)
    assert len(result.faces) == len(SOUP.faces)
    merged = len(np.unique(SOUP.vertices, axis=0)) - len(np.unique(result.vertices, axis=0))
    assert merged == 6


@settings(deadline=None, max_examples=10)
@given(seed=seeds)
def test_scale_changes_only_the_size(seed: int) -> None:
    for strength, factor in enumerate((0.5, 0.875, 1.25, 1.625, 2.0), start=1):
        result = transform(TORUS, "scale", strength, seed)
        np.testing.assert_allclose(result.vertices, factor * TORUS.vertices, rtol=1e-12)
        np.testing.assert_array_equal(result.faces, TORUS.faces)
        assert result.area == pytest.approx(factor**2 * TORUS.area)


@settings(deadline=None, max_examples=15)
@given(seed=seeds)
def test_local_scale_pushes_outward_in_proportion_to_strength(seed: int) -> None:
    shifts = [
        transform(TORUS, "local_scale", strength, seed).vertices - TORUS.vertices for strength in (1, 5)
    ]
    np.testing.assert_allclose(shifts[1], 5 * shifts[0], atol=1e-12)
    heights = np.linalg.norm(shifts[0], axis=1)
    unit = 0.008 * diagonal(TORUS)
    # A lone bump is one unit high, three at one place are three.
    assert unit * 0.99 <= heights.max() <= 3 * unit
    tube = TORUS.vertices * [1, 1, 0]
    outward = TORUS.vertices - 3 * tube / np.linalg.norm(tube, axis=1, keepdims=True)
    assert (
        np.einsum("ij,ij->i", shifts[0], outward) >= 0.99 * heights * np.linalg.norm(outward, axis=1)
    ).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_local_scale_and_noise_do_not_tear_seams(shape: str) -> None:
    mesh = SHAPES[shape]
    for kind in ("local_scale", "noise", "shot_noise"):
        result = transform(mesh, kind, 5, 2)
        assert len(np.unique(result.vertices, axis=0)) == len(np.unique(mesh.vertices, axis=0))


@pytest.mark.parametrize("shape", SHAPES)
def test_sampling_reaches_the_share_of_faces(shape: str) -> None:
    mesh = SHAPES[shape]
    for strength, share in enumerate((0.50, 0.35, 0.25, 0.20, 0.15), start=1):
        result = transform(mesh, "sampling", strength, 0)
        assert len(result.faces) / len(mesh.faces) == pytest.approx(share, rel=0.05)
        assert result.area == pytest.approx(mesh.area, rel=0.05)


def test_sampling_of_loose_triangles_merges_them_by_place() -> None:
    rng = np.random.default_rng(0)
    corners = TORUS.vertices[TORUS.faces]
    shrunk = corners.mean(axis=1, keepdims=True) + 0.9 * (corners - corners.mean(axis=1, keepdims=True))
    loose = soup(Mesh(shrunk.reshape(-1, 3), np.arange(corners.shape[0] * 3).reshape(-1, 3)))
    loose = Mesh(loose.vertices + 1e-3 * rng.standard_normal(loose.vertices.shape), loose.faces)
    for strength, share in ((1, 0.5), (5, 0.15)):
        result = transform(loose, "sampling", strength, 0)
        assert 0.8 * share <= len(result.faces) / len(loose.faces) <= 1.02 * share


@settings(deadline=None, max_examples=15)
@given(seed=seeds, strength=strengths)
def test_partial_takes_a_half_space_and_balls(seed: int, strength: int) -> None:
    result = transform(TORUS, "partial", strength, seed)
    left = len(result.vertices) / len(TORUS.vertices)
    assert left <= 1 - (0.05 + 0.05 * strength) + 0.01
    # s balls of radius 0.06 D take at most about π r² each, on both sides of nothing else.
    most = strength * 4 * np.pi * (0.06 * diagonal(TORUS)) ** 2 / TORUS.area
    assert left >= 1 - (0.05 + 0.05 * strength) - most - 0.05


def test_mixed_is_noise_holes_and_scale_of_the_strength_below() -> None:
    for strength, factor in ((1, 0.5), (2, 0.5), (3, 0.875), (5, 1.625)):
        result = transform(TORUS, "mixed", strength, 8)
        size = np.ptp(result.vertices, axis=0).max() / np.ptp(TORUS.vertices, axis=0).max()
        assert size == pytest.approx(factor, rel=0.2)
        assert len(result.vertices) < len(TORUS.vertices)
        roughness = face_areas(result).std() / face_areas(result).mean()
        assert roughness > face_areas(TORUS).std() / face_areas(TORUS).mean()
    np.testing.assert_array_equal(
        transform(TORUS, "mixed", 1, 8).vertices, transform(TORUS, "mixed", 2, 8).vertices
    )


class TestTinyAndBroken:
    tetrahedron = Mesh(np.eye(4)[:, :3], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], "tetrahedron")

    @pytest.mark.parametrize("kind", ["noise", "shot_noise", "scale", "local_scale"])
    def test_moving_vertices_always_works(self, kind: str) -> None:
        for strength in range(1, 6):
            assert len(transform(self.tetrahedron, kind, strength, 0).faces) == 4

    def test_one_vertex_less_leaves_one_face(self) -> None:
        assert len(transform(self.tetrahedron, "micro_holes", 1, 0).faces) == 1

    @pytest.mark.parametrize(
        ("kind", "strength"), [("holes", 1), ("mixed", 5), ("topology", 1), ("partial", 2)]
    )
    def test_impossible_is_refused_with_the_name(self, kind: str, strength: int) -> None:
        with pytest.raises(MeshError, match="'tetrahedron'"):
            transform(self.tetrahedron, kind, strength, 0)

    def test_what_cannot_be_done_says_why(self) -> None:
        with pytest.raises(MeshError, match=r"'tetrahedron' has only \d+ places .* topology 5 welds 15"):
            transform(self.tetrahedron, "topology", 5, 0)
        one_face = Mesh(self.tetrahedron.vertices, self.tetrahedron.faces[:1], "corner")
        with pytest.raises(
            MeshError, match="'corner': holes leaves none of its 1 faces; the mesh is too coarse"
        ):
            transform(one_face, "holes", 5, 0)

    def test_point_cloud(self) -> None:
        with pytest.raises(MeshError, match="'cloud' has no faces"):
            transform(Mesh(np.eye(3), name="cloud"), "noise", 1, 0)

    def test_no_extent(self) -> None:
        with pytest.raises(MeshError, match="'dot': all points of its faces coincide"):
            transform(Mesh(np.ones((4, 3)), [[0, 1, 2], [1, 2, 3]], "dot"), "noise", 1, 0)

    def test_unknown_kind_and_strength(self) -> None:
        with pytest.raises(ValueError, match="no transformation 'isometry'; there are noise"):
            transform(TORUS, "isometry", 1, 0)
        with pytest.raises(ValueError, match="strength must be 1 … 5, not 6"):
            transform(TORUS, "noise", 6, 0)

    def test_unused_vertices_do_not_count(self) -> None:
        far = Mesh(np.vstack([TORUS.vertices, [[1e6, 0, 0]]]), TORUS.faces)
        assert 0 < len(transform(far, "holes", 3, 0).vertices) < len(TORUS.vertices)
        assert len(transform(far, "holes", 3, 0).faces) > 0.5 * len(TORUS.faces)


class TestBend:
    @settings(deadline=None, max_examples=15)
    @given(seed=seeds, strength=st.floats(0.2, 2))
    @example(seed=1165, strength=0.2)  # the longest tail among 4500 bends
    @example(seed=587, strength=1.0)
    def test_is_as_nearly_isometric_as_asked(self, seed: int, strength: int) -> None:
        bent = bend(TORUS, seed, strength)
        np.testing.assert_array_equal(bent.faces, TORUS.faces)
        changes = edge_length_changes(TORUS, bent)
        assert 0.5 * 0.03 * strength < np.median(changes) <= 0.03 * strength
        assert np.percentile(changes, 95) < 0.5 * strength, "a wild one; the next test bounds the usual ones"
        np.testing.assert_array_equal(bent.vertices, bend(TORUS, seed, strength).vertices)

    def test_few_bends_stretch_a_part_much(self) -> None:
        tails = [np.percentile(edge_length_changes(TORUS, bend(TORUS, seed)), 95) for seed in range(60)]
        assert np.median(tails) < 0.15
        assert np.quantile(tails, 0.95) < 0.22

    def test_a_rod_turns_far(self) -> None:
        rod = trimesh.creation.cylinder(radius=0.02, height=4, sections=12)
        fine = rod.subdivide_to_size(0.2)
        mesh = Mesh(fine.vertices, fine.faces)
        shortened = [np.ptp(bend(mesh, seed).vertices, axis=0).max() / 4 for seed in range(5)]
        assert min(shortened) < 0.95
        for seed in range(5):
            assert bend(mesh, seed).area == pytest.approx(mesh.area, rel=0.1)

    def test_soup_stays_together(self) -> None:
        bent = bend(SOUP, 3)
        assert len(np.unique(np.round(bent.vertices, 9), axis=0)) == len(np.unique(SOUP.vertices, axis=0))

    def test_flat_sheet(self) -> None:
        x, y = np.meshgrid(np.linspace(0, 3, 30), np.linspace(0, 1, 10), indexing="ij")
        i, j = np.meshgrid(np.arange(29), np.arange(9), indexing="ij")
        a = (i * 10 + j).ravel()
        faces = np.concatenate([np.stack([a, a + 10, a + 11], 1), np.stack([a, a + 11, a + 1], 1)])
        sheet = Mesh(np.stack([x.ravel(), y.ravel(), np.zeros(300)], axis=1), faces)
        bent = bend(sheet, 0)
        assert np.isfinite(bent.vertices).all()
        assert np.median(edge_length_changes(sheet, bent)) <= 0.03
        assert not np.allclose(bent.vertices, sheet.vertices, atol=0.01)

    def test_refuses_nonsense(self) -> None:
        with pytest.raises(ValueError, match="strength must be positive, not 0"):
            bend(TORUS, 0, 0)
        with pytest.raises(MeshError, match="has no faces"):
            bend(Mesh(np.eye(3)), 0)
        with pytest.raises(ValueError, match="do not have the same faces"):
            edge_length_changes(TORUS, SOUP)
