# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender that reads .blend and .fbx files for the worker processes of the core.

Run as a script, by `blender -b -P reader.py` or by a Python that has bpy; it answers the requests described
in `shapegoogle_core.indexing.external_reader`. It imports nothing but bpy and `sharing`, since a Blender
started with factory settings has neither this add-on nor its wheels. Scripts inside the files never run, and
the files are only read.
"""

from __future__ import annotations

import ctypes
import importlib.util
import json
import os
import signal
import sys
from array import array
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import bpy

__all__ = ["main"]

# As in shapegoogle_core.processes.messages, which cannot be imported here.
MESSAGES = "SHAPEGOOGLE_MESSAGES"
# Blender's z.
UP_AXIS = 2
# Option of Linux's prctl for the signal that a process gets when its parent ends.
PR_SET_PDEATHSIG = 1


def main() -> None:
    """Answer one request after the other until the input is closed."""
    _end_with_parent()
    answers = _message_pipe()
    _reply(answers, {"ready": True})
    limited = False
    # In binary, since the encoding of text differs under Windows and in the C locale.
    for line in sys.stdin.buffer:
        request = json.loads(line)
        if not limited and request.get("memory_limit") is not None:
            _limit_memory(request["memory_limit"])
            limited = True
        try:
            answer = read(request)
        except (RuntimeError, OSError, ValueError) as error:
            answer = {"error": _reason(request["path"], error)}
        except MemoryError:
            limit = request["memory_limit"]
            reason = f"needs more than {limit} MB of memory; simplify it or raise the memory limit"
            answer = {"error": f"{Path(request['path']).name!r} {reason}"}
        _reply(answers, answer)


def _message_pipe() -> int:
    """File descriptor for answers: Blender and other libraries print on the standard streams, from C too."""
    number = int(os.environ.pop(MESSAGES))
    if sys.platform == "win32":
        import msvcrt

        number = msvcrt.open_osfhandle(number, os.O_WRONLY)
    os.set_inheritable(number, False)
    return number


def _reply(answers: int, answer: dict[str, Any]) -> None:
    """Send an answer as one line; in ASCII, so that no name can break it."""
    rest = memoryview(json.dumps(answer).encode("ascii") + b"\n")
    while rest:
        rest = rest[os.write(answers, rest) :]


def _end_with_parent() -> None:
    """Have Linux end this process when its parent ends, even if the parent is killed and Blender is busy.

    On other systems it ends when it next reads its input, which is closed then, but not while Blender hangs
    over a file: no other thread of Python runs during a call into Blender.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)


def _limit_memory(megabytes: int) -> None:
    """Limit the memory that this process may use on top of what it holds now; on Linux only."""
    if sys.platform == "linux":
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + megabytes * 2**20
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def read(request: dict[str, Any]) -> dict[str, Any]:
    """Open a file and write its shapes.

    Parameters
    ----------
    request : dict
        "path", "output" and "objects": "all", or "assets" for only those marked as assets where there are
        any.

    Returns
    -------
    answer : dict
        "shapes", "problems", "joined" (whether the shapes are parts of one) and "up_axis".

    Raises
    ------
    RuntimeError
        If Blender cannot open the file.
    """
    path = Path(request["path"])
    is_fbx = path.suffix.lower() == ".fbx"
    if is_fbx:
        _import_fbx(path)
    else:
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
    objects = _shape_objects()
    if request.get("objects") == "assets":
        objects = _assets(objects) or objects
    with Path(request["output"]).open("wb") as output:
        # Like the other files for exchange, an .fbx is one shape; a .blend is one for each object.
        return {**_write_shapes(objects, output), "joined": is_fbx, "up_axis": UP_AXIS}


def _reason(path: str, error: Exception) -> str:
    """Summarise Blender's report in one sentence."""
    name = Path(path).name
    if Path(path).stat().st_size == 0:
        return f"{name!r} cannot be opened by Blender: it is empty (0 bytes); copy or save it again"
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    text = "; ".join(line.removeprefix("Error: ") for line in lines)
    if isinstance(error, OSError):
        text = error.strerror or ""
    elif not text or "Traceback (most recent call last)" in text:
        text = "its importer fails"
    # Blender repeats the whole path, which the user sees elsewhere.
    text = text.replace(path, name).rstrip(".")
    return (
        f"{name!r} cannot be opened by Blender: {text}; it is damaged or another kind of file: save it again"
    )


def _import_fbx(path: Path) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    # Blender 4.5 has an importer of its own; earlier ones, an add-on that factory settings switch on.
    if "fbx_import" in dir(bpy.ops.wm):
        bpy.ops.wm.fbx_import(filepath=str(path), use_anim=False)
    else:
        bpy.ops.import_scene.fbx(filepath=str(path), use_anim=False)


def _shape_objects() -> list[Any]:
    """Meshes and point clouds of the open file, by name, without those of linked libraries."""
    kinds = ("MESH", "POINTCLOUD")
    found = [item for item in bpy.data.objects if item.type in kinds and item.library is None]
    return sorted(found, key=lambda item: item.name)


def _assets(objects: list[Any]) -> list[Any]:
    """Return the objects that are marked as assets, alone or with their collection."""
    marked = {item for item in objects if item.asset_data is not None}
    for collection in bpy.data.collections:
        if collection.asset_data is not None:
            marked.update(collection.all_objects)
    return [item for item in objects if item in marked]


def _tags(item: Any) -> list[str]:
    """Return the tags of an asset; none for an object that is not marked as one."""
    return [] if item.asset_data is None else [tag.name for tag in item.asset_data.tags]


def _write_shapes(objects: list[Any], output: BinaryIO) -> dict[str, Any]:
    shapes: list[dict[str, Any]] = []
    problems: list[str] = []
    meshes: Any = _module("sharing").SharedMeshes(objects)
    for item, evaluated in _evaluated(objects):
        matrix, content = evaluated.matrix_world, meshes.content(evaluated)
        shape = None if content is None else meshes.find(item, matrix, content)
        if shape is None:
            try:
                positions, faces = _arrays(evaluated)
            except RuntimeError as error:
                problems.append(f"{item.name!r} has no mesh once evaluated ({error}); check its modifiers")
                continue
            if not positions:
                continue
            content = meshes.read(evaluated, positions, faces)
            shape = meshes.find(item, matrix, content)
        if shape is None:
            positions.tofile(output)
            faces.tofile(output)
            counts = {"vertices": len(positions) // 3, "faces": len(faces) // 3}
            shape = {"name": item.name, **counts, "placements": [], "tags": []}
            shapes.append(shape)
            meshes.put(item, matrix, content, shape)
        numbers = [number for row in matrix for number in row]
        shape["placements"].append({"object": item.name, "matrix": numbers})
        shape["tags"] += [tag for tag in _tags(item) if tag not in shape["tags"]]
    return {"shapes": shapes, "problems": problems}


def _module(name: str) -> Any:
    """Load a module from beside this script, which is in no package when it runs."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    assert spec is not None and spec.loader is not None  # noqa: PT018 - the path ends with .py
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _arrays(evaluated: Any) -> tuple[array[float], array[int]]:
    """Coordinates and triangles of an evaluated object, in its own space.

    A mesh without triangles gets no vertices either: wires and single points are helpers, not shapes.
    """
    faces = array("i")
    if evaluated.type == "POINTCLOUD":
        return _positions(evaluated.data.points), faces
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        faces = array("i", bytes(12 * len(mesh.loop_triangles)))
        mesh.loop_triangles.foreach_get("vertices", faces)
        return _positions(mesh.vertices) if faces else array("f"), faces
    finally:
        evaluated.to_mesh_clear()


def _positions(points: Any) -> array[float]:
    positions = array("f", bytes(12 * len(points)))
    points.foreach_get("co", positions)
    return positions


def _evaluated(objects: list[Any]) -> Iterator[tuple[Any, Any]]:
    """Yield each object with its evaluated state, also if it is hidden or in no scene.

    They are evaluated together in a scene of their own, where everything is visible. Objects they depend on
    (armatures, targets of modifiers) are evaluated without being in it.
    """
    if not objects:
        return
    frame = bpy.context.scene.frame_current
    scene = bpy.data.scenes.new("Shape Google")
    scene.frame_set(frame)
    for item in objects:
        item.hide_viewport = False
        scene.collection.objects.link(item)
        item.update_tag()  # Blender 4.2 and 4.5 leave the matrix of another scene's object as it was
    layer = scene.view_layers[0]
    layer.update()
    depsgraph = layer.depsgraph
    depsgraph.update()
    for item in objects:
        yield item, item.evaluated_get(depsgraph)


if __name__ == "__main__":
    main()
