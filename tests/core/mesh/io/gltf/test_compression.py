# SPDX-License-Identifier: MIT
"""Compressed glTF: meshopt in all its forms, and Draco."""

from __future__ import annotations

import base64
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from shapegoogle_core.mesh import read_mesh
from tests.core.mesh.io.gltf.builder import BOX, GltfBuilder
from tests.core.mesh.io.mesh_files import AREA, TRIANGLES, VOLUME, refuse, volume

STREAMS = json.loads((Path(__file__).parent / "meshopt_streams.json").read_text())
"""Made by meshoptimizer's own encoder of the arrays below, in base64."""

Values = NDArray[Any]


def wave(count: int = 300) -> Values:
    """Points on a curve, as floats."""
    steps = np.arange(count)
    return np.column_stack([steps / 8, (steps * steps % 97) / 4, 5 - steps // 7]).astype("<f4")


def rough(count: int = 300) -> Values:
    """Points without any order, as 16-bit numbers of which the fourth is padding."""
    numbers = (np.arange(count)[:, None] * [7919, 104729, 1299709, 0] % 65521).astype("<u2")
    numbers[:, 3] = 0
    return numbers


def level(count: int = 300) -> Values:
    """Points of which two coordinates are steps of a few, as 16-bit numbers."""
    steps = np.arange(count)
    return np.column_stack([steps // 3, steps % 5, np.full(count, 9), 0 * steps]).astype("<u2")


def places(count: int = 20) -> Values:
    """Places of instances; whole numbers, which the exponential filter keeps."""
    return np.column_stack([np.arange(count) * 10, np.zeros(count), np.arange(count) % 3]).astype("<f4")


ATTRIBUTES = {"wave": wave(), "rough": rough(), "level": level()}

GRID = np.arange(12 * 9, dtype=np.uint32).reshape(12, 9)
CELLS = np.stack(
    [GRID[:-1, :-1], GRID[1:, :-1], GRID[:-1, 1:], GRID[1:, :-1], GRID[1:, 1:], GRID[:-1, 1:]], axis=-1
)
INDICES = {
    "grid": CELLS.ravel(),
    "box": np.ravel(TRIANGLES).astype(np.uint32),
    "rough": (np.arange(300, dtype=np.uint32) * 7919 % 211),
    "far": np.array([0, 1, 2, 70_000, 69_999, 70_001, 2, 70_000, 5, 9, 9, 0], np.uint32),
}
"""Corners of triangles: of a regular grid, of a box, in no order, and far from each other."""


def compressed(made: GltfBuilder, name: str, values: Values, **more: Any) -> int:
    """Append a compressed view whose fallback, buffer 1, has no data."""
    rows = values.reshape(len(values), -1)
    data = base64.b64decode(STREAMS[name])
    made.data += b"\0" * (-len(made.data) % 4)
    packed = {
        "buffer": 0,
        "byteOffset": len(made.data),
        "byteLength": len(data),
        "byteStride": rows.strides[0],
        "count": len(rows),
        "mode": "ATTRIBUTES",
    }
    made.data += data
    if len(made.tree["buffers"]) < 2:
        made.add("buffers", byteLength=10**6)
    extension = more.pop("extension", "EXT_meshopt_compression")
    made.tree["extensionsRequired"] = [extension]
    return made.add(
        "bufferViews",
        buffer=1,
        byteLength=rows.nbytes,
        extensions={extension: packed | more},
    )


def points_of(made: GltfBuilder, view: int, values: Values) -> GltfBuilder:
    """Show the values of a view as points."""
    accessor = made.accessor_of(view, values[:, :3])
    if values.shape[1] == 4:
        made.tree["bufferViews"][view]["byteStride"] = values.strides[0]
    made.scene(made.add("nodes", mesh=made.add("meshes", primitives=[])))
    made.tree["meshes"][0]["primitives"] = [{"mode": 0, "attributes": {"POSITION": accessor}}]
    return made


@pytest.mark.parametrize("extension", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
@pytest.mark.parametrize("name", [name for name in STREAMS if name.startswith("attributes")])
def test_attributes(tmp_path: Path, name: str, extension: str) -> None:
    values = ATTRIBUTES[name.split()[1]]
    made = GltfBuilder()
    view = compressed(made, name, values, extension=extension)
    read = read_mesh(points_of(made, view, values).save(tmp_path))
    assert np.array_equal(read.vertices, values[:, :3])


def test_places_of_instances(tmp_path: Path) -> None:
    """The exponential filter stores floats, the quaternion filter rotations."""
    made = GltfBuilder()
    shifts = compressed(made, "exponential places", places(), filter="EXPONENTIAL")
    turned = np.tile(np.array([0, 0, 32767, 0], "<i2"), (20, 1))
    turns = compressed(made, "quaternion turns", turned, filter="QUATERNION")
    attributes = {
        "TRANSLATION": made.accessor_of(shifts, places()),
        "ROTATION": made.accessor_of(turns, turned, normalized=True),
    }
    extensions = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    made.scene(made.add("nodes", mesh=made.mesh(), extensions=extensions))
    mesh = made.read(tmp_path)
    assert volume(mesh) == pytest.approx(20 * VOLUME)
    # Turned by half a circle about z, the boxes lie at negative x and y.
    assert mesh.vertices.min(axis=0) == pytest.approx([-2, -1, 0], abs=1e-3)
    assert mesh.vertices.max(axis=0) == pytest.approx([190, 0, 5], abs=1e-3)


@pytest.mark.parametrize("mode", ["TRIANGLES", "INDICES"])
@pytest.mark.parametrize("name", INDICES)
@pytest.mark.parametrize("dtype", ["u2", "u4"])
def test_indices(tmp_path: Path, name: str, mode: str, dtype: str) -> None:
    corners = INDICES[name]
    if corners.max() > 65535 and dtype == "u2":
        pytest.skip("too large for 16 bits")
    made = GltfBuilder()
    count = int(corners.max()) + 1
    points = np.column_stack([np.arange(count), np.arange(count) ** 2 % 89, np.arange(count) % 7])
    expected = points[corners].reshape(-1, 3, 3)
    view = compressed(made, f"{mode.lower()} {name}", corners.astype("<" + dtype), mode=mode)
    accessor = made.accessor_of(view, corners.astype("<" + dtype))
    mesh = made.mesh(points)
    made.tree["meshes"][mesh]["primitives"][0]["indices"] = accessor
    made.scene(made.add("nodes", mesh=mesh))
    read = made.read(tmp_path)
    # The order of the corners of a triangle may begin elsewhere.
    found = read.vertices[read.faces]
    turns = np.stack([found[:, [0, 1, 2]], found[:, [1, 2, 0]], found[:, [2, 0, 1]]])
    assert (turns == expected).all(axis=(2, 3)).any(axis=0).all()


def test_fallback_buffers(tmp_path: Path) -> None:
    """A file without compressed data for a view is read as it is."""
    made = GltfBuilder()
    made.scene(made.add("nodes", mesh=made.mesh()))
    made.tree["extensionsRequired"] = ["EXT_meshopt_compression"]
    assert volume(made.read(tmp_path)) == pytest.approx(VOLUME)


def test_streams_that_are_damaged(tmp_path: Path) -> None:
    values = wave()
    for change in (
        {"byteLength": 40},
        {"byteLength": 1},
        {"byteLength": 0},
        {"count": 600},
        {"count": 3},
        {"byteStride": 16},
        {"mode": "INDICES", "byteStride": 4},
        {"mode": "TRIANGLES", "byteStride": 4},
    ):
        made = GltfBuilder()
        view = compressed(made, "attributes wave 0", values, **change)
        refuse(
            points_of(made, view, values).save(tmp_path),
            "meshopt data in bufferViews[0].extensions.EXT_meshopt",
        )
    refused: list[tuple[dict[str, Any], str]] = [
        ({"mode": "OTHER"}, "the mode 'OTHER'"),
        ({"byteStride": 6}, "with 6 bytes"),
        ({"filter": "OCTAHEDRAL"}, "the meshopt filter 'OCTAHEDRAL'"),
        ({"count": 10**12}, "claims 1,000,000,000,000 values"),
        ({"count": 100}, "that cannot be decoded"),
    ]
    for changes, word in refused:
        made = GltfBuilder()
        view = compressed(made, "attributes wave 0", values, **changes)
        refuse(points_of(made, view, values).save(tmp_path), word)


def draco_box(made: GltfBuilder, data: bytes, numbers: dict[str, int], **primitive: Any) -> GltfBuilder:
    """Show a box that is stored in Draco data alone."""
    view = made.view(data)
    extension = {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": numbers}}
    position = made.accessor_of(None, BOX)
    corners = made.accessor_of(None, np.ravel(TRIANGLES).astype(np.uint16))
    values = {"attributes": {"POSITION": position}, "indices": corners, "extensions": extension}
    made.scene(made.add("nodes", mesh=made.add("meshes", primitives=[values | primitive])))
    made.tree["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    return made


def test_draco(tmp_path: Path) -> None:
    draco = pytest.importorskip("DracoPy")
    data = draco.encode(BOX, np.array(TRIANGLES, np.uint32), quantization_bits=14)
    mesh = draco_box(GltfBuilder(), data, {"POSITION": 0}).read(tmp_path)
    assert (len(mesh.faces), mesh.area) == pytest.approx((12, AREA), rel=1e-3)
    refuse(
        draco_box(GltfBuilder(), data, {"POSITION": 5}).save(tmp_path),
        "no attribute POSITION in the Draco data",
    )
    refuse(draco_box(GltfBuilder(), data, {}).save(tmp_path), "has no 'POSITION'")
    for broken in (data[:30], b"nothing", b"DRACO" + bytes(50)):
        refuse(draco_box(GltfBuilder(), broken, {"POSITION": 0}).save(tmp_path), "Draco data in meshes[0]")


def test_draco_with_whole_numbers(tmp_path: Path) -> None:
    """Draco stores them with more bits than the accessor has, which says what they stand for."""
    draco = pytest.importorskip("DracoPy")
    steps = (BOX * 42).astype(np.int32)
    data = draco.encode(steps, np.array(TRIANGLES, np.uint32))
    made = draco_box(GltfBuilder(), data, {"POSITION": 0})
    made.tree["accessors"][0] |= {"componentType": 5120, "normalized": True}
    assert made.read(tmp_path).extents == pytest.approx(np.array([2, 1, 3]) * 42 / 127)


def test_draco_beside_plain_data(tmp_path: Path) -> None:
    """Where the accessors have their own data, no decoder is needed."""
    made = GltfBuilder()
    mesh = made.mesh()
    extension = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    made.tree["meshes"][mesh]["primitives"][0]["extensions"] = extension
    made.scene(made.add("nodes", mesh=mesh))
    assert volume(made.read(tmp_path)) == pytest.approx(VOLUME)


def test_draco_without_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    path = draco_box(GltfBuilder(), b"DRACO", {"POSITION": 0}).save(tmp_path)
    refuse(path, "compressed with Draco (KHR_draco_mesh_compression)", "DracoPy", "export the file without")
