# SPDX-License-Identifier: MIT
"""What Blender itself makes of a model file: its importers, and its evaluated meshes.

Run as a script, by `blender -b -P in_blender.py` or by a Python that has bpy. It imports nothing of this
repository. Each line of its input is JSON with the paths of a file and of an output file; it answers with
one line. The output has the arrays of each part one after the other: vertices (float32), triangles (int32).
A part is an object of a .blend file, or all of another file.
"""

from __future__ import annotations

import json
import os
import sys
from array import array
from pathlib import Path
from typing import Any, BinaryIO, TextIO

import bpy

__all__ = ["main"]

# As in `shapegoogle_core.processes.messages`, which cannot be imported here.
MESSAGES = "SHAPEGOOGLE_MESSAGES"


def main() -> None:
    """Answer one request after the other until the input is closed."""
    number = int(os.environ.pop(MESSAGES))
    if sys.platform == "win32":
        import msvcrt

        number = msvcrt.open_osfhandle(number, os.O_WRONLY)
    answers = os.fdopen(number, "w", encoding="ascii")
    _reply(answers, {"ready": bpy.app.version_string})
    for line in sys.stdin.buffer:
        request = json.loads(line)
        try:
            answer = read(Path(request["path"]), Path(request["output"]))
        except Exception as error:  # importers fail in every way, and the others must still be read
            answer = {"error": " ".join(str(error).split()) or type(error).__name__}
        _reply(answers, answer)


def _reply(answers: TextIO, answer: dict[str, Any]) -> None:
    print(json.dumps(answer), file=answers, flush=True)


def read(path: Path, output: Path) -> dict[str, Any]:
    """Open or import a file and write its parts.

    Parameters
    ----------
    path : Path
    output : Path

    Returns
    -------
    answer : dict
        "parts": names and counts.

    Raises
    ------
    RuntimeError
        If Blender cannot read the file.
    """
    suffix = path.suffix.lower()
    with output.open("wb") as file:
        if suffix == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
            # Wires and single vertices are helpers there; in other files vertices may be all there is.
            return {"parts": _write_objects(file, with_wires=False)}
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        _import(path, suffix)
        return {"parts": [{**part, "name": ""} for part in _write_objects(file, with_wires=True)]}


def _import(path: Path, suffix: str) -> None:
    """Import a file without turning its axes; `readers` turns those of glTF back."""
    options: dict[str, object]
    if suffix in (".glb", ".gltf"):
        operator, options = bpy.ops.import_scene.gltf, {"disable_bone_shape": True}
    elif suffix == ".fbx":
        new = "fbx_import" in dir(bpy.ops.wm)
        operator, options = bpy.ops.wm.fbx_import if new else bpy.ops.import_scene.fbx, {"use_anim": False}
    else:
        operator = getattr(bpy.ops.wm, f"{suffix[1:]}_import")
        options = {"forward_axis": "Y", "up_axis": "Z", "use_mesh_validate": False}
    known = operator.get_rna_type().properties.keys()
    operator(filepath=str(path), **{name: value for name, value in options.items() if name in known})


def _write_objects(output: BinaryIO, with_wires: bool) -> list[dict[str, Any]]:
    """Write what the scenes of the open file show; what an object instances is a part of its own."""
    parts: list[dict[str, Any]] = []
    seen: set[str] = set()
    for scene in bpy.data.scenes:
        for layer in scene.view_layers:
            layer.update()
            names = set()
            for instance in layer.depsgraph.object_instances:
                item = instance.object
                name = f"{instance.parent.name} (instances)" if instance.is_instance else item.name
                names.add(name)
                if name in seen or item.type not in ("MESH", "POINTCLOUD") or item.original.library:
                    continue
                counts = _write_shape(item, output, with_wires)
                matrix = [number for row in instance.matrix_world for number in row]
                parts.append({"name": name, **counts, "matrix": matrix})
            seen |= names
    return parts


def _write_shape(item: Any, output: BinaryIO, with_wires: bool) -> dict[str, int]:
    if item.type == "POINTCLOUD":
        return {"vertices": _write(item.data.points, "co", "f", output), "faces": 0}
    mesh = item.to_mesh()
    mesh.calc_loop_triangles()
    counts = {"vertices": 0, "faces": 0}
    if with_wires or len(mesh.loop_triangles):
        counts["vertices"] = _write(mesh.vertices, "co", "f", output)
        counts["faces"] = _write(mesh.loop_triangles, "vertices", "i", output)
    item.to_mesh_clear()
    return counts


def _write(items: Any, attribute: str, kind: str, output: BinaryIO) -> int:
    values = array(kind, bytes(12 * len(items)))
    items.foreach_get(attribute, values)
    values.tofile(output)
    return len(items)


if __name__ == "__main__":
    main()
