# SPDX-License-Identifier: GPL-3.0-or-later
"""The script that tells what Blender itself reads, for `python -m benchmarks files`."""

from __future__ import annotations

from array import array
from pathlib import Path

import bpy

from benchmarks.experiments.files import in_blender


def read(path: Path, tmp_path: Path) -> list[tuple[str, int, int, list[float]]]:
    """Name, counts and coordinates of each part."""
    output = tmp_path / "parts.bin"
    parts = in_blender.read(path, output)["parts"]
    values = array("f")
    found = []
    with output.open("rb") as file:
        for part in parts:
            values = array("f")
            values.frombytes(file.read(12 * part["vertices"]))
            file.read(12 * part["faces"])
            found.append((part["name"], part["vertices"], part["faces"], values.tolist()))
    return found


def test_a_file_for_exchange_is_one_part_in_its_own_axes(tmp_path: Path) -> None:
    path = tmp_path / "part.obj"
    path.write_text("o a\nv 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 4\nf 1 2 3 4\no b\nv 1 1 1\nf 1 2 5\n")
    parts = read(path, tmp_path)
    assert {name for name, *_ in parts} == {""}
    assert sum(faces for _, _, faces, _ in parts) == 3
    first = parts[0][3]
    assert sorted(zip(first[::3], first[1::3], first[2::3], strict=True)) == [
        (0, 0, 0), (0, 0, 4), (0, 3, 0), (2, 0, 0)
    ]  # fmt: skip


def test_the_objects_of_a_blend_file_with_instances(tmp_path: Path) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    collection = bpy.data.collections.new("Kit")
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    collection.objects.link(cube)
    carrier = bpy.data.objects.new("Carrier", None)
    carrier.instance_type, carrier.instance_collection = "COLLECTION", collection
    wire = bpy.data.objects.new("Wire", bpy.data.meshes.new("Wire"))
    wire.data.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    for item in (carrier, wire):
        bpy.context.scene.collection.objects.link(item)
    path = tmp_path / "kit.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    parts = {name: (vertices, faces) for name, vertices, faces, _ in read(path, tmp_path)}
    assert parts == {"Cube": (8, 12), "Carrier (instances)": (8, 12), "Wire": (0, 0)}
