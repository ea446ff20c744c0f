# SPDX-License-Identifier: MIT
"""Default poses of glTF: morph targets and skins."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.core.mesh.io.gltf.builder import BOX, GltfBuilder
from tests.core.mesh.io.mesh_files import VOLUME, refuse, volume

TOP = BOX[:, 2] > 1
"""The corners of the box at z = 3; the others are at z = 0."""


def morphed(mesh: dict[str, Any], node: dict[str, Any]) -> GltfBuilder:
    """A box whose first target lifts the top by 1, and whose second one moves the side at x = 2 by 10."""
    made = GltfBuilder()
    targets = [
        {"POSITION": made.accessor(np.outer(TOP, [0, 0, 1]))},
        {"POSITION": made.accessor(np.outer(BOX[:, 0] > 1, [10, 0, 0]))},
        {"NORMAL": made.accessor(np.ones((8, 3)))},
    ]
    made.scene(made.add("nodes", mesh=made.mesh(targets=targets, **mesh), **node))
    return made


@pytest.mark.parametrize(
    ("mesh", "node", "extents"),
    [
        ({}, {}, (2, 1, 3)),
        ({"weights": [0, 0, 0]}, {}, (2, 1, 3)),
        ({"weights": [1, 0, 0]}, {}, (2, 1, 4)),
        ({"weights": [0.5, -0.1, 1]}, {}, (1, 1, 3.5)),
        ({"weights": [1]}, {}, (2, 1, 4)),  # the others are 0
        ({"weights": [1, 1, 0]}, {"weights": [0, 0, 0]}, (2, 1, 3)),  # the node's count
        ({"weights": [1, 1, 0]}, {"weights": [0, 2, 0]}, (22, 1, 3)),
        ({}, {"weights": [3, 0, 0]}, (2, 1, 6)),
    ],
)
def test_default_weights_of_morph_targets(
    tmp_path: Path, mesh: dict[str, Any], node: dict[str, Any], extents: tuple[float, float, float]
) -> None:
    assert morphed(mesh, node).read(tmp_path).extents == pytest.approx(extents)


def test_one_mesh_with_other_weights_in_each_node(tmp_path: Path) -> None:
    made = morphed({"weights": [1, 0, 0]}, {"weights": [2, 0, 0]})
    made.add("nodes", mesh=0, translation=[5, 0, 0])
    made.add("nodes", mesh=0, translation=[9, 0, 0], weights=[0, 0, 0])
    made.tree["scenes"][0]["nodes"] = [0, 1, 2]
    vertices = made.read(tmp_path).vertices
    heights = [np.ptp(vertices[abs(vertices[:, 0] - x) < 3][:, 2]) for x in (1, 6, 10)]
    assert heights == pytest.approx([5, 4, 3])


def test_targets_that_do_not_fit(tmp_path: Path) -> None:
    made = morphed({"weights": [1, 0, 0]}, {})
    short = made.accessor(np.ones((7, 3)))
    made.tree["meshes"][0]["primitives"][0]["targets"][0] = {"POSITION": short}
    refuse(made.save(tmp_path), "7 values for 8 vertices in meshes[0].primitives[0].targets[0]")


INFLUENCES = np.zeros((8, 4))
INFLUENCES[:, 0] = 1


def skinned(
    joints: np.ndarray[Any, Any] | None = None,
    weights: np.ndarray[Any, Any] | None = None,
    dtype: str = "f4",
    inverse: np.ndarray[Any, Any] | None = None,
    **node: Any,
) -> GltfBuilder:
    """A box with two joints in nodes 1 and 2: the first stays, the second is 10 up and below the first.

    Unless others are given, the joint of the bottom is the first one, of the top the second.
    """
    made = GltfBuilder()
    if joints is None:
        joints = np.outer(TOP, [1, 0, 0, 0])
    if weights is None:
        weights = INFLUENCES
    attributes = {}
    for number in range(joints.shape[1] // 4):
        part = slice(4 * number, 4 * number + 4)
        attributes[f"JOINTS_{number}"] = made.accessor(joints[:, part], "u1")
        attributes[f"WEIGHTS_{number}"] = made.accessor(weights[:, part], dtype, normalized=dtype != "f4")
    mesh = made.mesh(attributes=attributes)
    more = {} if inverse is None else {"inverseBindMatrices": made.accessor(inverse.reshape(-1, 16))}
    skin = made.add("skins", joints=[1, 2], **more)
    made.add("nodes", mesh=mesh, skin=skin, **node)
    made.add("nodes", children=[2])
    made.add("nodes", translation=[0, 0, 10])
    made.scene(0, 1)
    return made


def test_joints_move_a_skinned_mesh(tmp_path: Path) -> None:
    assert skinned().read(tmp_path).extents == pytest.approx((2, 1, 13))


def test_the_node_of_a_skinned_mesh_does_not_count(tmp_path: Path) -> None:
    plain = skinned().read(tmp_path)
    for place in ({"translation": [5, 5, 5]}, {"scale": [-3, 3, 3]}, {"rotation": [1, 0, 0, 0]}):
        made = skinned()
        made.tree["nodes"][0] |= place
        made.add("nodes", children=[0], scale=[7, 7, 7])
        made.tree["scenes"] = [{"nodes": [3, 1]}]
        mesh = made.read(tmp_path)
        assert np.allclose(mesh.vertices, plain.vertices)
        assert volume(mesh) == pytest.approx(volume(plain))


def test_the_nodes_above_the_joints_count(tmp_path: Path) -> None:
    made = skinned()
    made.add("nodes", children=[1], scale=[2, 2, 2], translation=[100, 0, 0])
    made.tree["scenes"] = [{"nodes": [0, 3]}]
    mesh = made.read(tmp_path)
    assert mesh.extents == pytest.approx((4, 2, 26))
    assert mesh.vertices[:, 0].min() == pytest.approx(100)


def test_inverse_bind_matrices(tmp_path: Path) -> None:
    """Matrices that undo the places of the joints leave the mesh as it was modelled."""
    inverse = np.stack([np.eye(4), np.eye(4)])
    inverse[1, 3, 2] = -10  # column by column: the last four numbers are the translation
    assert skinned(inverse=inverse).read(tmp_path).extents == pytest.approx((2, 1, 3))
    refuse(skinned(inverse=inverse[:1]).save(tmp_path), "1 inverse bind matrices for 2 joints in skins[0]")


def test_mirrored_joints_are_not_inside_out(tmp_path: Path) -> None:
    made = skinned(np.zeros((8, 4)))
    made.tree["nodes"][1]["scale"] = [-1, 1, 1]
    assert volume(made.read(tmp_path)) == pytest.approx(VOLUME)


@pytest.mark.parametrize(("dtype", "most"), [("f4", 1), ("u1", 255), ("u2", 65535)])
def test_weights_of_all_types(tmp_path: Path, dtype: str, most: int) -> None:
    joints = np.outer(TOP, [0, 1, 0, 0])
    weights = np.tile([0.4 * most, 0.6 * most, 0, 0], (8, 1))
    extents = skinned(joints, np.round(weights) if most > 1 else weights, dtype).read(tmp_path).extents
    assert extents == pytest.approx((2, 1, 3 + 6), rel=2e-3)  # the top follows the second joint by 0.6


def test_weights_that_do_not_add_up_to_one(tmp_path: Path) -> None:
    joints = np.outer(TOP, [0, 1, 0, 0])
    assert skinned(joints, np.tile([2, 2, 0, 0], (8, 1))).read(tmp_path).extents == pytest.approx((2, 1, 8))
    # Without any influence, a vertex follows the first joint that it names.
    assert skinned(joints, np.zeros((8, 4))).read(tmp_path).extents == pytest.approx((2, 1, 3))


def test_more_than_four_influences(tmp_path: Path) -> None:
    joints = np.zeros((8, 8))
    joints[TOP, 4:] = 1
    weights = np.full((8, 8), 1 / 8)
    assert skinned(joints, weights).read(tmp_path).extents == pytest.approx((2, 1, 3 + 5))


def test_a_skin_without_influences_is_left_out(tmp_path: Path) -> None:
    made = skinned(translation=[5, 0, 0])
    attributes = made.tree["meshes"][0]["primitives"][0]["attributes"]
    del attributes["JOINTS_0"]
    mesh = made.read(tmp_path)
    assert mesh.extents == pytest.approx((2, 1, 3))
    assert mesh.vertices[:, 0].min() == pytest.approx(5)


def test_morph_targets_come_before_the_joints(tmp_path: Path) -> None:
    made = skinned()
    made.tree["nodes"][2]["scale"] = [1, 1, 2]
    primitive = made.tree["meshes"][0]["primitives"][0]
    primitive["targets"] = [{"POSITION": made.accessor(np.outer(TOP, [0, 0, 1]))}]
    made.tree["meshes"][0]["weights"] = [1]
    assert made.read(tmp_path).extents == pytest.approx((2, 1, 2 * 4 + 10))


def test_skins_that_are_damaged(tmp_path: Path) -> None:
    refuse(skinned(np.full((8, 4), 9)).save(tmp_path), "names joint 9, counted from 0, of 2")
    # A joint without influence may be any.
    joints = np.add(np.outer(TOP, [1, 0, 0, 0]), [0, 9, 9, 9])
    assert skinned(joints).read(tmp_path).extents == pytest.approx((2, 1, 13))
    made = skinned()
    made.tree["skins"] = []
    refuse(made.save(tmp_path), "names skins[0] in nodes[0], but has only 0 skins")
    made = skinned()
    made.tree["skins"][0]["joints"] = [1, 20]
    refuse(made.save(tmp_path), "names nodes[20] in skins[0]")
    made.tree["skins"][0]["joints"] = []
    refuse(made.save(tmp_path), "skins[0]")
