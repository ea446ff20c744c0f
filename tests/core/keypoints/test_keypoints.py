# SPDX-License-Identifier: MIT
"""Detectors on shapes where it is known what stands out, and what must not change what they find."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

import shapegoogle_core as sg
from shapegoogle_core.keypoints import DETECTORS, detect_keypoints, persistent_maxima
from shapegoogle_core.keypoints.harris import fit_quadrics, harris_response
from shapegoogle_core.keypoints.scale_space import diffusions, signed_mean_curvature
from shapegoogle_core.keypoints.surroundings import adjacency, discs, maxima_in
from shapegoogle_core.laplacian import build_operator

DIRECTIONS = np.array([[1.0, 0.2, 0.1], [-0.3, 1, 0.2], [0.2, -0.4, 1], [-1, -0.8, -0.9], [0.6, -1, -0.5]])
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
EIGENPAIRS = 60


def path(count: int) -> np.ndarray:
    """Edges of vertices in a row."""
    return np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)


def with_bumps(sphere: sg.Mesh, centers: np.ndarray, height: float = 0.6, sharpness: float = 30.0) -> sg.Mesh:
    """A unit sphere with a bump at each of some unit vectors."""
    rise = height * np.exp(-sharpness * (1 - sphere.vertices @ centers.T)).sum(axis=1)
    return sg.Mesh(sphere.vertices * (1 + rise)[:, None], sphere.faces, "bumps")


def keypoints(mesh: sg.Mesh, detector: str, **parameters: float) -> sg.Keypoints:
    return detect_keypoints(mesh, sg.compute_spectrum(mesh, EIGENPAIRS), detector, **parameters)


class TestPersistence:
    def test_of_a_range_known_by_hand(self):
        # 3 meets 5 at 1, 4 meets 5 at 2.5, 2 meets 5 at 0.5. The lowest point is 0.
        heights = np.array([0, 3, 1, 5, 2.5, 4, 0.5, 2, 0.25])
        maxima, deaths = persistent_maxima(heights, path(9))
        assert maxima.tolist() == [3, 5, 1, 7]
        assert deaths.tolist() == [0, 2.5, 1, 0.5]

    def test_the_elder_survives_on_a_ring(self):
        ring = np.concatenate([path(6), [[5, 0]]])
        maxima, deaths = persistent_maxima(np.array([4.0, 1, 3, 0, 2, 1.5]), ring)
        assert (maxima.tolist(), deaths.tolist()) == ([0, 2, 4], [0, 1, 1.5])

    def test_of_equal_heights_the_smaller_index_counts_as_higher(self):
        maxima, deaths = persistent_maxima(np.array([1.0, 1, 0, 1, 1]), path(5))
        assert (maxima.tolist(), deaths.tolist()) == ([0, 3], [0, 0])

    def test_parts_have_a_highest_each(self):
        maxima, deaths = persistent_maxima(np.array([5.0, 4, 1, 2, 7]), np.array([[0, 1], [2, 3]]))
        assert (maxima.tolist(), deaths.tolist()) == ([4, 0, 3], [7, 4, 1])

    @settings(max_examples=60, deadline=None)
    @given(st.integers(0, 2**32 - 1))
    def test_islands_of_one_level_that_are_left_at_another(self, seed):
        """The numbers of such islands, for all pairs of levels, are all that persistence can say."""
        random = np.random.default_rng(seed)
        n = 12
        heights = random.permutation(n).astype(float)
        edges = random.integers(0, n, (14, 2))
        maxima, deaths = persistent_maxima(heights, edges[edges[:, 0] != edges[:, 1]])
        births = heights[maxima]
        _, part = _islands(np.ones(n, bool), edges)
        for_ever = np.array([heights[m] == heights[part == part[m]].max() for m in maxima])
        deaths = np.where(for_ever, -1, deaths)
        for low in range(n):
            above, island = _islands(heights >= low, edges)
            for high in range(low, n):
                left = len(set(island[above & (heights >= high)]))
                assert left == ((births >= high) & (deaths < low)).sum()


def _islands(above: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    kept = edges[above[edges].all(axis=1)]
    graph = sparse.coo_array((np.ones(len(kept)), kept.T), shape=(len(above), len(above)))
    return above, connected_components(graph, directed=False)[1]


class TestSurroundings:
    def test_discs_of_a_plane_are_round(self, shapes):
        plane = shapes.rectangle(1, 1, 20)
        distance = np.linalg.norm(plane.vertices[:, None] - plane.vertices[None], axis=2)
        # A disc of 4.2 edges holds two rings.
        assert np.array_equal(discs(plane, 0.21).toarray() > 0, distance <= 0.21)

    def test_the_other_side_of_a_sheet_is_not_near(self, shapes):
        front = shapes.rectangle(1, 1, 10)
        back = sg.Mesh(front.vertices + np.array([0, 0, 0.01]), front.faces)
        n = len(front.vertices)
        both = sg.Mesh(
            np.concatenate([front.vertices, back.vertices]), np.concatenate([front.faces, back.faces + n])
        )
        assert discs(both, 0.3)[:n, n:].nnz == 0

    def test_maxima(self, shapes):
        plane = shapes.rectangle(1, 1, 10)
        values = -np.linalg.norm(plane.vertices - [0.5, 0.5, 0], axis=1)
        assert np.flatnonzero(maxima_in(values, adjacency(plane))).tolist() == [5 * 11 + 5]
        # Of a plateau the first.
        assert np.flatnonzero(maxima_in(np.zeros(121), discs(plane, 2.0))).tolist() == [0]


class TestHeatKernelMaxima:
    @pytest.mark.parametrize("count", [1, 2, 3, 5])
    def test_a_sphere_with_bumps_has_one_on_each(self, shapes, count):
        centers = DIRECTIONS[:count]
        mesh = with_bumps(shapes.sphere(4), centers)
        found = keypoints(mesh, "hks-maxima")
        directions = mesh.vertices[found.indices]
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        angles = np.degrees(np.arccos(np.clip(directions @ centers.T, -1, 1)))
        assert len(found) == count
        assert sorted(angles.argmin(axis=1)) == list(range(count))
        assert angles.min(axis=1).max() < 4  # an edge

    def test_nothing_stands_out_on_a_sphere(self, shapes):
        assert len(keypoints(shapes.sphere(3), "hks-maxima")) == 0

    def test_response_is_the_rise_over_the_saddle(self, shapes):
        mesh = with_bumps(shapes.sphere(3), DIRECTIONS[:2])
        spectrum = sg.compute_spectrum(mesh, EIGENPAIRS)
        found = detect_keypoints(mesh, spectrum, "hks-maxima", time=0.02)
        heat = sg.heat_kernel_signature(spectrum, 0.02 * spectrum.area)[:, 0]
        assert found.response[0] == pytest.approx(1 - heat.min() / heat.max())
        assert found.indices[0] == heat.argmax()
        more = detect_keypoints(mesh, spectrum, "hks-maxima", time=0.02, persistence=0.9 * found.response[1])
        between = found.response.mean()
        less = detect_keypoints(mesh, spectrum, "hks-maxima", time=0.02, persistence=between)
        assert (len(more), len(less)) == (2, 1)

    def test_a_small_part_does_not_drown_the_large_one(self, shapes):
        large = with_bumps(shapes.sphere(3), DIRECTIONS[:2])
        small = shapes.sphere(2)
        mesh = sg.Mesh(
            np.concatenate([large.vertices, 0.05 * small.vertices + 3]),
            np.concatenate([large.faces, small.faces + len(large.vertices)]),
        )
        assert set(keypoints(large, "hks-maxima").indices) <= set(keypoints(mesh, "hks-maxima").indices)

    def test_bending_changes_nothing(self, shapes):
        flat = shapes.rectangle(2, 1, 40)
        angle = 2 * flat.vertices[:, 0]
        rolled = np.stack([np.sin(angle) / 2, flat.vertices[:, 1], np.cos(angle) / 2], axis=1)
        first, second = (keypoints(mesh, "hks-maxima") for mesh in (flat, sg.Mesh(rolled, flat.faces)))
        # The corners, where heat cannot get away.
        assert set(first.indices) == {0, 20, 40 * 21, 41 * 21 - 1} == set(second.indices)
        assert second.response == pytest.approx(first.response, rel=0.01)


@pytest.fixture(scope="module")
def cube() -> sg.Mesh:
    box = trimesh.creation.box()
    for _ in range(4):
        box = box.subdivide()
    return sg.Mesh(box.vertices, box.faces, "cube")


class TestHarris:
    def test_corners_of_a_cube(self, cube):
        found = cube.vertices[keypoints(cube, "harris-3d").indices]
        assert len(np.unique(np.sign(found), axis=0)) == 8 == len(found)
        # Within an edge of the mesh.
        assert np.linalg.norm(np.abs(found) - 0.5, axis=1).max() < 1 / 15

    def test_edges_are_below_and_faces_at_zero(self, cube):
        spectrum = sg.compute_spectrum(cube, 4)
        joined, everywhere = discs(cube, 0.12), np.arange(len(cube.vertices))
        response = harris_response(fit_quadrics(cube, spectrum.mass, joined, everywhere, unit=0.12))
        beside = 0.5 - np.abs(cube.vertices)
        near = (beside < 0.25).sum(axis=1)  # of how many further faces a vertex is near, and its own
        edge = ((beside < 1e-9).sum(axis=1) == 2) & (near == 2)
        assert response[edge].max() < 0
        assert np.abs(response[near == 1]).max() < 1e-12

    def test_response_by_integration(self):
        """The closed form of E, against the mean of ∇z∇zᵀ by Gauss-Hermite quadrature."""
        quadric = np.random.default_rng(0).standard_normal(6)
        p1, p2, p3, p4, p5, _ = quadric
        nodes, weights = np.polynomial.hermite_e.hermegauss(5)
        x, y = np.meshgrid(nodes, nodes)
        weight = np.outer(weights, weights) / weights.sum() ** 2
        slope = np.stack([p1 * x + p2 * y + p4, p2 * x + p3 * y + p5])
        matrix = np.einsum("ixy,jxy,xy->ij", slope, slope, weight)
        expected = np.linalg.det(matrix) - 0.04 * np.trace(matrix) ** 2
        assert harris_response(quadric[None])[0] == pytest.approx(expected)

    def test_quadrics_of_a_sphere(self, shapes):
        sphere = shapes.sphere(4)
        spectrum = sg.compute_spectrum(sphere, 4)
        p1, p2, p3, *_ = fit_quadrics(
            sphere, spectrum.mass, discs(sphere, 0.15), np.arange(len(sphere.vertices))
        ).T
        # Curvature 1 in every direction, whichever way the normal looks.
        assert np.abs(np.abs(p1) - 1).max() < 0.03
        assert np.abs(np.abs(p3) - 1).max() < 0.03
        assert np.abs(p2).max() < 0.03

    def test_quadrics_of_a_function(self, shapes):
        plane = shapes.rectangle(1, 1, 20)
        x, y, _ = plane.vertices.T
        center = np.array([10 * 21 + 10])
        joined, mass = discs(plane, 0.2)[center], np.ones(len(x))
        quadric = fit_quadrics(plane, mass, joined, center, 3 * (x - 0.5) ** 2 + (y - 0.5) ** 2 / 2 + x)[0]
        curvatures = np.linalg.eigvalsh(quadric[[0, 1, 1, 2]].reshape(2, 2))
        assert curvatures == pytest.approx([1, 6], rel=1e-3)
        assert np.hypot(quadric[3], quadric[4]) == pytest.approx(1, rel=1e-3)


class TestScaleSpace:
    def test_signed_mean_curvature_of_a_sphere(self, shapes):
        sphere = shapes.sphere(4)
        large = sg.Mesh(2.5 * sphere.vertices, sphere.faces)
        curvature = signed_mean_curvature(large, build_operator(large))
        # The twelve vertices of an icosphere that have five neighbours are off by a seventh.
        assert np.median(curvature) == pytest.approx(0.4, rel=0.01)
        assert curvature == pytest.approx(0.4, rel=0.15)

    def test_signed_mean_curvature_of_a_flat_sheet_with_a_rim(self, shapes):
        plane = shapes.rectangle(1, 1, 10)
        assert np.abs(signed_mean_curvature(plane, build_operator(plane))).max() < 1e-10

    def test_diffusion_damps_a_wave_as_heat_does(self, shapes):
        """z is an eigenfunction of the unit sphere with eigenvalue 2: it decays as exp(-2t)."""
        sphere = shapes.sphere(4)
        steps = np.linspace(0.002, 0.2, 100)
        z = sphere.vertices[:, 2]
        smoothed = diffusions(build_operator(sphere), z, steps)
        for time, values in ((steps[9], smoothed[9]), (steps[-1], smoothed[-1])):
            assert values @ z / (z @ z) == pytest.approx(np.exp(-2 * time), rel=0.005)

    @pytest.mark.parametrize("detector", ["mesh-dog", "salient-points"])
    def test_a_bump_is_found(self, shapes, detector):
        centers = DIRECTIONS[:3]
        mesh = with_bumps(shapes.sphere(4), centers, height=0.4, sharpness=15)
        found = keypoints(mesh, detector)
        strongest = mesh.vertices[found.indices[:3]]
        strongest /= np.linalg.norm(strongest, axis=1, keepdims=True)
        cosines = strongest @ centers.T
        assert sorted(cosines.argmax(axis=1)) == [0, 1, 2]
        assert np.degrees(np.arccos(cosines.max(axis=1).clip(-1, 1))).max() < 5

    def test_a_dent_is_found_too(self, shapes):
        mesh = with_bumps(shapes.sphere(4), DIRECTIONS[:1], height=-0.15, sharpness=10)
        strongest = mesh.vertices[keypoints(mesh, "mesh-dog").indices[0]]
        assert strongest @ DIRECTIONS[0] / np.linalg.norm(strongest) > np.cos(np.radians(5))

    def test_a_ridge_is_none(self, shapes):
        """Around a straight fold the difference changes in one direction only."""
        sheet = shapes.rectangle(1, 1, 40)
        x, y, _ = sheet.vertices.T
        fold = sg.Mesh(np.stack([x, y, 0.2 * np.exp(-((x - 0.5) ** 2) / 0.005)], axis=1), sheet.faces)
        found = keypoints(fold, "mesh-dog").indices
        inner = found[np.abs(fold.vertices[found, 1] - 0.5) < 0.25]
        assert len(inner) == 0


@pytest.mark.parametrize("detector", DETECTORS)
class TestEveryDetector:
    @settings(max_examples=5, deadline=None)
    @given(seed=st.integers(0, 2**32 - 1))
    def test_motion_scale_and_order_of_vertices_do_not_matter(self, bumpy, detector, seed):
        random = np.random.default_rng(seed)
        turned = bumpy.vertices @ Rotation.random(random_state=random).as_matrix().T
        moved = 10 ** random.uniform(-3, 3) * (turned + random.normal(0, 5, 3))
        order = random.permutation(len(moved))
        mesh = sg.Mesh(moved[order], np.argsort(order)[bumpy.faces])
        before, after = keypoints(bumpy, detector), keypoints(mesh, detector)
        assert order[after.indices].tolist() == before.indices.tolist()
        assert after.response == pytest.approx(before.response, rel=1e-4)

    def test_points_are_vertices_the_strongest_first(self, bumpy, detector):
        found = keypoints(bumpy, detector)
        assert len(found) == len(set(found.indices)) > 0
        assert (np.diff(found.response) <= 0).all()
        assert found.response.min() > 0

    def test_open_and_loose_parts_are_no_trouble(self, bumpy, shapes, detector):
        half = bumpy.faces[(bumpy.vertices[bumpy.faces][:, :, 2] > 0).all(axis=1)]
        used, faces = np.unique(half, return_inverse=True)
        sheet = shapes.rectangle(1, 1, 5)
        mesh = sg.Mesh(
            np.concatenate([bumpy.vertices[used], sheet.vertices + 4]),
            np.concatenate([faces.reshape(-1, 3), sheet.faces + len(used)]),
        )
        found = keypoints(mesh, detector)
        assert np.isfinite(found.response).all()

    def test_a_coarse_mesh_has_an_answer(self, detector):
        box = trimesh.creation.box()
        assert len(keypoints(sg.Mesh(box.vertices, box.faces), detector)) <= 8


class TestRefusals:
    def test_unknown_names_and_values(self, bumpy):
        spectrum = sg.compute_spectrum(bumpy, 10)
        with pytest.raises(ValueError, match="detector must be one of hks-maxima, mesh-dog"):
            detect_keypoints(bumpy, spectrum, "sift")
        with pytest.raises(ValueError, match="no parameter 'radius'; it has time, persistence"):
            detect_keypoints(bumpy, spectrum, "hks-maxima", radius=1.0)
        with pytest.raises(ValueError, match="time of 'hks-maxima' must be positive, not -1"):
            detect_keypoints(bumpy, spectrum, "hks-maxima", time=-1.0)
        with pytest.raises(ValueError, match="must not be below the smallest"):
            detect_keypoints(bumpy, spectrum, "mesh-dog", smallest=0.2, largest=0.1)

    def test_a_spectrum_of_another_mesh(self, bumpy, shapes):
        spectrum = sg.compute_spectrum(shapes.sphere(2), 10)
        with pytest.raises(sg.MeshError, match=r"bumpy sphere.*spectrum of that mesh"):
            detect_keypoints(bumpy, spectrum)
