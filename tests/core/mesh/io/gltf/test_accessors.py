# SPDX-License-Identifier: MIT
"""Numbers of glTF: types, strides, sparse changes; and primitives of all modes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.core.mesh.io.gltf.builder import BOX, GltfBuilder
from tests.core.mesh.io.mesh_files import AREA, TRIANGLES, VOLUME, refuse, volume


def shown(made: GltfBuilder, mesh: int, **node: Any) -> GltfBuilder:
    made.scene(made.add("nodes", mesh=mesh, **node))
    return made


def with_positions(made: GltfBuilder, accessor: int, **node: Any) -> GltfBuilder:
    """Show a box whose positions are another accessor."""
    mesh = made.mesh()
    made.tree["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"] = accessor
    return shown(made, mesh, **node)


@pytest.mark.parametrize("index", ["u1", "u2", "u4"])
def test_indices_of_all_types(tmp_path: Path, index: str) -> None:
    made = GltfBuilder()
    assert volume(shown(made, made.mesh(index=index)).read(tmp_path)) == pytest.approx(VOLUME)


def test_without_indices(tmp_path: Path) -> None:
    made = GltfBuilder()
    corners = BOX[np.array(TRIANGLES)].reshape(-1, 3)
    mesh = shown(made, made.mesh(corners, None)).read(tmp_path)
    assert (len(mesh.vertices), len(mesh.faces)) == (36, 12)
    assert volume(mesh) == pytest.approx(VOLUME)


@pytest.mark.parametrize("dtype", ["i1", "u1", "i2", "u2"])
@pytest.mark.parametrize("normalized", [False, True])
def test_quantised_positions(tmp_path: Path, dtype: str, normalized: bool) -> None:
    """Whole numbers stand for themselves, or for −1…1; the node makes them as large as they were."""
    most = np.iinfo(dtype).max
    made = GltfBuilder()
    steps = np.round(BOX / 3 * most)
    width = 4 // np.dtype(dtype).itemsize if dtype[1] == "1" else 4
    padded = np.zeros((8, width), "<" + dtype)  # rows begin at multiples of four bytes
    padded[:, :3] = steps
    view = made.view(padded.tobytes(), byteStride=padded.strides[0])
    accessor = made.accessor_of(view, steps.astype(dtype), normalized=normalized)
    made.tree["extensionsRequired"] = ["KHR_mesh_quantization"]
    scale = 3.0 if normalized else 3.0 / most
    mesh = with_positions(made, accessor, scale=[scale] * 3).read(tmp_path)
    assert mesh.extents == pytest.approx((2, 1, 3), rel=0.02 if dtype[1] == "1" else 1e-3)


def test_the_lowest_whole_number_stands_for_minus_one(tmp_path: Path) -> None:
    made = GltfBuilder()
    steps = np.where(BOX > 0, 127, -128).astype(np.int8)
    view = made.view(np.pad(steps, ((0, 0), (0, 1))).tobytes(), byteStride=4)
    mesh = with_positions(made, made.accessor_of(view, steps, normalized=True)).read(tmp_path)
    assert mesh.extents == (2, 2, 2)


def test_interleaved_attributes(tmp_path: Path) -> None:
    """Position and normal of each vertex behind each other; two accessors share a view."""
    made = GltfBuilder()
    rows = np.hstack([np.full((8, 3), 9, np.float32), BOX])
    view = made.view(rows.tobytes(), byteStride=24)
    made.accessor_of(view, BOX)
    mesh = with_positions(made, made.accessor_of(view, BOX, byteOffset=12)).read(tmp_path)
    assert np.array_equal(np.unique(mesh.vertices, axis=0), np.unique(BOX, axis=0))


def test_sparse_positions(tmp_path: Path) -> None:
    """Some values of an accessor are replaced; without a view, the others are zeros."""
    high = np.flatnonzero(BOX[:, 2] > 1)
    for with_view in (True, False):
        made = GltfBuilder()
        base = np.where(BOX[:, 2:] > 1, 99, BOX).astype(np.float32) if with_view else np.zeros_like(BOX)
        places = high if with_view else np.arange(8)
        sparse = {
            "count": len(places),
            "indices": {"bufferView": made.view(places.astype("<u2").tobytes()), "componentType": 5123},
            "values": {"bufferView": made.view(BOX[places].astype("<f4").tobytes())},
        }
        view = made.view(base.tobytes()) if with_view else None
        mesh = with_positions(made, made.accessor_of(view, BOX, sparse=sparse)).read(tmp_path)
        assert volume(mesh) == pytest.approx(VOLUME)
    sparse["count"] = 9
    refuse(made.save(tmp_path), "replaces 9 of 8 values in accessors[")
    sparse["count"] = 8
    made.tree["accessors"][-3]["count"] = 4
    refuse(made.save(tmp_path), "")


def test_sparse_indices_and_targets(tmp_path: Path) -> None:
    made = GltfBuilder()
    wrong = np.array(TRIANGLES).ravel()
    right = wrong.copy()
    wrong[5:8] = 0
    places = {"bufferView": made.view(np.array([5, 6, 7], np.uint8).tobytes()), "componentType": 5121}
    values = {"bufferView": made.view(right[5:8].astype("<u2").tobytes())}
    mesh = made.mesh(faces=wrong)
    corners = made.tree["accessors"][-1]
    corners["sparse"] = {"count": 3, "indices": places, "values": values}
    primitive = made.tree["meshes"][mesh]["primitives"][0]
    lifted = {"bufferView": made.view(np.array([[0, 0, 5]], "<f4").tobytes())}
    places = {"bufferView": made.view(np.array([6], np.uint8).tobytes()), "componentType": 5121}
    target = made.accessor_of(None, BOX, sparse={"count": 1, "indices": places, "values": lifted})
    primitive["targets"] = [{"POSITION": target}]
    assert volume(shown(made, mesh).read(tmp_path)) == pytest.approx(VOLUME)
    made.tree["meshes"][mesh]["weights"] = [1]
    assert made.read(tmp_path).extents == pytest.approx((2, 1, 8))


GRID = np.array([[x, y, 0] for x in range(3) for y in (0, 1)], np.float32)
"""Six points of a ladder of 2 × 1: a strip."""


def test_triangle_strip(tmp_path: Path) -> None:
    made = GltfBuilder()
    mesh = shown(made, made.mesh(GRID, range(6), mode=5)).read(tmp_path)
    assert (len(mesh.faces), mesh.area) == pytest.approx((4, 2))
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    assert (np.cross(b - a, c - a)[:, 2] < 0).all()  # all on one side


def test_joined_strips(tmp_path: Path) -> None:
    """Corners that are named twice lead from one strip to the next; they are no triangles."""
    made = GltfBuilder()
    mesh = made.mesh(np.vstack([GRID, np.add(GRID, [0, 5, 0])]), [*range(6), 5, 6, *range(6, 12)], mode=5)
    read = shown(made, mesh).read(tmp_path)
    assert (len(read.faces), read.area) == pytest.approx((8, 4))


def test_triangle_fan(tmp_path: Path) -> None:
    made = GltfBuilder()
    angles = np.linspace(0, 2 * np.pi, 7)
    rim = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    mesh = shown(made, made.mesh(np.vstack([[0, 0, 0], rim]), None, mode=6)).read(tmp_path)
    assert (len(mesh.faces), mesh.area) == pytest.approx((6, 6 * np.sqrt(3) / 4))


def test_an_incomplete_triangle_is_left_out(tmp_path: Path) -> None:
    made = GltfBuilder()
    corners = [*np.ravel(TRIANGLES), 0, 1]
    assert len(shown(made, made.mesh(faces=corners)).read(tmp_path).faces) == 12


def test_primitives_that_share_positions(tmp_path: Path) -> None:
    """Each takes only the vertices that it names."""
    made = GltfBuilder()
    mesh = made.mesh(np.vstack([BOX, BOX + 100]), TRIANGLES)
    primitives = made.tree["meshes"][mesh]["primitives"]
    second = made.accessor(np.ravel(TRIANGLES) + 8, "u2")
    primitives.append({"attributes": primitives[0]["attributes"], "indices": second})
    read = shown(made, mesh).read(tmp_path)
    assert (len(read.vertices), read.area) == pytest.approx((16, 2 * AREA))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"type": "VEC2"}, ("'VEC2' in accessors[0]", "VEC3 is expected")),
        ({"type": 3}, ("3 as accessors[0].type", "a text")),
        ({"componentType": 1}, ("unknown component type 1 in accessors[0]",)),
        ({"componentType": "float"}, ("accessors[0].componentType",)),
        ({"count": 10**12}, ("claims 1,000,000,000,000 values in accessors[0]",)),
        ({"count": 10**40}, ("accessors[0].count", "a whole number")),
        ({"count": -1}, ("-1 as accessors[0].count",)),
        ({"count": 9}, ("needs 108 bytes of bufferViews[0] for accessors[0]", "96")),
        ({"byteOffset": 8}, ("needs 104 bytes",)),
        ({"bufferView": 7}, ("names bufferViews[7] in accessors[0]",)),
        ({"count": 5}, ("names vertex", "of the 5 of meshes[0].primitives[0]")),
    ],
)
def test_accessors_that_are_damaged(tmp_path: Path, change: dict[str, Any], words: tuple[str, ...]) -> None:
    made = GltfBuilder()
    shown(made, made.mesh())
    made.tree["accessors"][0] |= change
    refuse(made.save(tmp_path), *words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mode": 9}, ("unknown mode 9 in meshes[0].primitives[0]",)),
        ({"indices": 0}, ("'VEC3' in accessors[0], where SCALAR is expected",)),
        ({"attributes": []}, ("[] as meshes[0].primitives[0].attributes", "an object")),
        ({"attributes": {"POSITION": 5}}, ("names accessors[5] in meshes[0].primitives[0].attributes",)),
        ({"attributes": {"NORMAL": 0}}, ("shows no triangles and no points",)),
    ],
)
def test_primitives_that_are_damaged(tmp_path: Path, change: dict[str, Any], words: tuple[str, ...]) -> None:
    made = GltfBuilder()
    shown(made, made.mesh())
    made.tree["meshes"][0]["primitives"][0] |= change
    refuse(made.save(tmp_path), *words)


def test_views_beyond_their_buffer(tmp_path: Path) -> None:
    made = GltfBuilder()
    shown(made, made.mesh())
    made.tree["bufferViews"][0]["byteOffset"] = 100
    refuse(made.save(tmp_path), "bufferViews[0] that ends at byte 196 of a buffer of 168 bytes")
    made.tree["bufferViews"][0]["buffer"] = 3
    refuse(made.save(tmp_path), "names buffers[3] in bufferViews[0]")
