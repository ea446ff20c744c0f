# SPDX-License-Identifier: MIT
"""Scenes of glTF: which nodes count, and where they put their meshes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.core.mesh.io.gltf.builder import BOX, GltfBuilder
from tests.core.mesh.io.mesh_files import AREA, VOLUME, refuse, volume

HALF = np.sqrt(0.5)


def box(**node: Any) -> GltfBuilder:
    """A box of 2 × 1 × 3 in one node of the only scene."""
    made = GltfBuilder()
    made.scene(made.add("nodes", mesh=made.mesh(), **node))
    return made


def test_transforms(tmp_path: Path) -> None:
    turned = {"rotation": [0, 0, HALF, HALF], "scale": [1, 2, 3], "translation": [10, 20, 30]}
    mesh = box(**turned).read(tmp_path)
    assert mesh.extents == pytest.approx((2, 2, 9))  # scaled to 2 × 2 × 9, then turned about z
    assert mesh.vertices.min(axis=0) == pytest.approx([8, 20, 30], abs=1e-6)
    matrix = np.array([[0, -2, 0, 10], [1, 0, 0, 20], [0, 0, 3, 30], [0, 0, 0, 1]])
    again = box(matrix=matrix.T.ravel().tolist()).read(tmp_path)
    assert np.allclose(again.vertices, mesh.vertices)


def test_a_rotation_that_is_not_of_unit_length(tmp_path: Path) -> None:
    assert box(rotation=[0, 0, 5, 5]).read(tmp_path).extents == pytest.approx((1, 2, 3))
    assert box(rotation=[0, 0, 0, 0]).read(tmp_path).extents == pytest.approx((2, 1, 3))


@pytest.mark.parametrize("scale", [[-1, 1, 1], [-1, -1, -1], [2, -3, 1]])
def test_mirrored_nodes_are_not_inside_out(tmp_path: Path, scale: list[float]) -> None:
    assert volume(box(scale=scale).read(tmp_path)) == pytest.approx(VOLUME * abs(np.prod(scale)))


def test_children_move_with_their_parents(tmp_path: Path) -> None:
    made = GltfBuilder()
    mesh = made.mesh()
    made.add("nodes", mesh=mesh, translation=[1, 0, 0])
    made.add("nodes", children=[0], scale=[-1, 2, 2])
    made.scene(made.add("nodes", children=[1], translation=[0, 0, 5]))
    read = made.read(tmp_path)
    assert read.vertices.min(axis=0) == pytest.approx([-3, 0, 5])
    assert read.vertices.max(axis=0) == pytest.approx([-1, 2, 11])
    assert volume(read) == pytest.approx(4 * VOLUME)


def two_scenes() -> GltfBuilder:
    """Two scenes; the second shows the box twice as large, and a third node is in none."""
    made = GltfBuilder()
    mesh = made.mesh()
    made.scene(made.add("nodes", mesh=mesh))
    made.scene(made.add("nodes", mesh=mesh, scale=[2, 2, 2]))
    made.add("nodes", mesh=mesh, scale=[3, 3, 3])
    return made


def test_the_default_scene_counts(tmp_path: Path) -> None:
    made = two_scenes()
    assert made.read(tmp_path).area == pytest.approx(AREA)  # the first one, as in viewers
    made.tree["scene"] = 1
    assert made.read(tmp_path).area == pytest.approx(4 * AREA)
    made.tree["scene"] = 2
    refuse(made.save(tmp_path), "names scenes[2]", "only 2 scenes")


def test_without_scenes_all_nodes_count(tmp_path: Path) -> None:
    made = two_scenes()
    del made.tree["scenes"]
    assert made.read(tmp_path).area == pytest.approx((1 + 4 + 9) * AREA)
    made.tree["scenes"] = []
    assert made.read(tmp_path).area == pytest.approx((1 + 4 + 9) * AREA)
    made.tree["scenes"] = [{"name": "empty"}]
    assert made.read(tmp_path).area == pytest.approx((1 + 4 + 9) * AREA)


def test_without_scenes_nodes_keep_their_places(tmp_path: Path) -> None:
    made = box(translation=[7, 0, 0])
    made.add("nodes", children=[0], translation=[0, 7, 0])
    del made.tree["scenes"]
    assert made.read(tmp_path).vertices.min(axis=0) == pytest.approx([7, 7, 0])


def test_meshes_without_a_node(tmp_path: Path) -> None:
    made = box()
    made.mesh(9 * BOX)  # in no scene, so not part of what the file shows
    assert made.read(tmp_path).area == pytest.approx(AREA)
    del made.tree["scenes"], made.tree["nodes"]
    assert made.read(tmp_path).area == pytest.approx(82 * AREA)


def test_a_scene_may_begin_below_another_node(tmp_path: Path) -> None:
    """As in files of UniGLTF, whose scenes name the child of an empty node."""
    made = box()
    made.add("nodes", children=[0], scale=[5, 5, 5])
    assert made.read(tmp_path).area == pytest.approx(AREA)
    made.tree["scenes"][0]["nodes"] = [0, 0]
    assert len(made.read(tmp_path).faces) == 12


def test_nodes_that_are_no_tree(tmp_path: Path) -> None:
    made = box()
    made.add("nodes", children=[2])
    made.add("nodes", children=[1])
    refuse(made.save(tmp_path), "nodes[1] below itself")
    made = box(children=[0])
    refuse(made.save(tmp_path), "nodes[0] below itself")
    made = box()
    made.add("nodes", children=[0])
    made.add("nodes", children=[0])
    refuse(made.save(tmp_path), "nodes[0] below two nodes")
    refuse(box(children=[8]).save(tmp_path), "names nodes[8] in nodes[0]")


def test_a_chain_of_many_nodes(tmp_path: Path) -> None:
    made = box()
    for number in range(3000):
        made.add("nodes", children=[number], translation=[1, 0, 0])
    made.tree["scenes"] = [{"nodes": [3000]}]
    assert made.read(tmp_path).vertices.min(axis=0) == pytest.approx([3000, 0, 0])


@pytest.mark.parametrize(
    ("node", "words"),
    [
        ({"matrix": [1, 2, 3]}, ("[1, 2, 3] as nodes[0].matrix", "16 numbers")),
        ({"translation": [1, 2, float("nan")]}, ("nodes[0].translation", "3 numbers")),
        ({"rotation": "none"}, ('"none" as nodes[0].rotation', "a list")),
        ({"mesh": -1}, ("-1 as nodes[0].mesh", "whole number")),
        ({"mesh": 7}, ("names meshes[7] in nodes[0]", "only 1 meshes")),
        ({"children": {}}, ("{} as nodes[0].children", "a list")),
    ],
)
def test_nodes_that_are_damaged(tmp_path: Path, node: dict[str, Any], words: tuple[str, ...]) -> None:
    made = box()
    made.tree["nodes"][0] |= node
    refuse(made.save(tmp_path), *words)


def instanced(**attributes: int) -> dict[str, Any]:
    return {"extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}


def test_instances(tmp_path: Path) -> None:
    made = box(scale=[2, 2, 2])
    shifts = made.accessor([[0, 0, 0], [10, 0, 0], [0, 10, 0]])
    turns = made.accessor([[0, 0, 0, 127], [0, 0, 90, 90], [0, 0, 0, 127]], "i1", normalized=True)
    scales = made.accessor([[1, 1, 1], [1, 1, 1], [-3, 3, 3]])
    made.tree["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    made.tree["nodes"][0] |= instanced(TRANSLATION=shifts, ROTATION=turns, SCALE=scales)
    mesh = made.read(tmp_path)
    assert len(mesh.faces) == 36
    assert mesh.area == pytest.approx(4 * (1 + 1 + 9) * AREA)
    assert volume(mesh) == pytest.approx(8 * (1 + 1 + 27) * VOLUME)
    # The instances are below their node: it makes their distances twice as large too.
    assert mesh.vertices.min(axis=0) == pytest.approx([-12, 0, 0], abs=1e-5)
    assert mesh.vertices.max(axis=0) == pytest.approx([20, 26, 18], abs=1e-5)


@pytest.mark.parametrize("dtype", ["i1", "i2"])
def test_instances_turned_by_whole_numbers(tmp_path: Path, dtype: str) -> None:
    made = box()
    half = round(HALF * np.iinfo(dtype).max)
    made.tree["nodes"][0] |= instanced(ROTATION=made.accessor([[half, 0, 0, half]], dtype, normalized=True))
    assert made.read(tmp_path).extents == pytest.approx((2, 3, 1))


def test_instances_without_places(tmp_path: Path) -> None:
    made = box()
    made.tree["nodes"][0] |= instanced()
    assert len(made.read(tmp_path).faces) == 12
    made.tree["nodes"][0] |= instanced(SCALE=made.accessor([[2, 2, 2], [4, 4, 4]]))
    assert made.read(tmp_path).area == pytest.approx((4 + 16) * AREA)
    made.tree["nodes"][0] |= instanced(TRANSLATION=made.accessor(np.zeros((0, 3))))
    refuse(made.save(tmp_path), "shows no triangles and no points")
    made.tree["nodes"][0] |= instanced(
        TRANSLATION=made.accessor(np.zeros((2, 3))), SCALE=made.accessor(np.ones((3, 3)))
    )
    refuse(made.save(tmp_path), "different numbers of instances in nodes[0].extensions")


def test_instances_count_for_the_limit(tmp_path: Path) -> None:
    made = box()
    made.tree["nodes"][0] |= instanced(TRANSLATION=made.accessor(np.zeros((100, 3))))
    refuse(made.save(tmp_path), "1,200 faces", "limit of 1,000", max_faces=1000)
    made.tree["nodes"] = [{"mesh": 0} for _ in range(100)]
    made.tree["scenes"] = [{"nodes": list(range(100))}]
    refuse(made.save(tmp_path), "1,200 faces", "limit of 1,000", max_faces=1000)


def test_points_and_lines(tmp_path: Path) -> None:
    points = np.random.default_rng(0).normal(size=(50, 3))
    made = GltfBuilder()
    made.scene(made.add("nodes", mesh=made.mesh(points, None, mode=0), translation=[5, 0, 0]))
    cloud = made.read(tmp_path)
    assert cloud.is_point_cloud
    assert np.allclose(cloud.vertices, np.add(points, [5, 0, 0]))
    refuse(made.save(tmp_path), "50 points", max_faces=49)
    made.tree["scenes"][0]["nodes"].append(made.add("nodes", mesh=made.mesh()))
    assert (len(made.read(tmp_path).vertices), made.read(tmp_path).area) == pytest.approx((8, AREA))
    for mode in (1, 2, 3):
        lines = GltfBuilder()
        lines.scene(lines.add("nodes", mesh=lines.mesh(points, None, mode=mode)))
        refuse(lines.save(tmp_path), "no triangles and no points: only lines")
