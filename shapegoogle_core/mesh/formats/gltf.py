# SPDX-License-Identifier: MIT
"""glTF 2.0, as text with buffers beside it (.gltf) or in one file (.glb), read with trimesh.

What trimesh does not read, or reads as something else without a word, is refused here with a sentence:
compressed, sparse and normalised positions; counts that the buffers cannot hold.
"""

from __future__ import annotations

import io
import json
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from shapegoogle_core.mesh.formats.common import FormatError, Geometry, check_face_count, file_size

__all__ = ["read_glb", "read_gltf"]

_MAGIC = 0x46546C67  # "glTF"
_JSON_CHUNK = 0x4E4F534A
_COMPRESSIONS = {"KHR_draco_mesh_compression": "Draco", "EXT_meshopt_compression": "meshopt"}
_TRIANGLES, _TRIANGLE_STRIP, _TRIANGLE_FAN = 4, 5, 6
_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def read_gltf(path: Path, max_faces: int) -> Geometry:
    """Read all meshes of a .gltf file's scene, in place, as one.

    Parameters
    ----------
    path : Path
        Buffers in other files are looked for in its folder and below, nowhere else.
    max_faces : int

    Returns
    -------
    vertices : (n, 3) array
    faces : (m, 3) array

    Raises
    ------
    FormatError
    """
    data = path.read_bytes()
    _check(_parse(data), max_faces)
    return _load(data, "gltf", path.parent)


def read_glb(path: Path, max_faces: int) -> Geometry:
    """Read all meshes of a .glb file's scene, in place, as one.

    Parameters
    ----------
    path : Path
    max_faces : int

    Returns
    -------
    vertices : (n, 3) array
    faces : (m, 3) array

    Raises
    ------
    FormatError
    """
    with path.open("rb") as file:
        start = np.frombuffer(file.read(20).ljust(20, b"\0"), "<u4").tolist()
        magic, version, length, json_length, json_type = start
        if magic != _MAGIC or version != 2:
            raise FormatError("does not begin like a binary glTF 2 file (.glb); export it again")
        if length > file_size(path) or 20 + json_length > length or json_type != _JSON_CHUNK:
            raise FormatError(
                f"claims {length:,} bytes, {json_length:,} of them JSON, but has {file_size(path):,}; "
                "it is damaged or was cut short: copy or export it again"
            )
        _check(_parse(file.read(json_length)), max_faces)
    return _load(path.read_bytes(), "glb", path.parent)


def _load(data: bytes, kind: str, folder: Path) -> Geometry:
    import trimesh

    neighbours: Any = _Neighbours(folder)
    with _quiet():
        scene = trimesh.load_scene(
            io.BytesIO(data), file_type=kind, resolver=neighbours, process=False, skip_materials=True
        )
        return _flatten(scene)


class _Neighbours:
    """What trimesh asks for the other files that a glTF names: regular files in its folder or below."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def get(self, name: str) -> bytes:
        neighbour = (self.folder / unquote(name)).resolve()
        if not neighbour.is_relative_to(self.folder) or not neighbour.is_file():
            raise FormatError(f"needs the file {name!r}, which is not beside it; copy both together")
        return neighbour.read_bytes()


def _parse(data: bytes) -> dict[str, Any]:
    try:
        header = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise FormatError(
            f"holds no valid JSON ({error}); it is damaged, cut short or no glTF file"
        ) from error
    if not isinstance(header, dict) or "asset" not in header:
        raise FormatError("has no 'asset' entry, so it is no glTF file; export it again")
    return header


def _check(header: dict[str, Any], max_faces: int) -> None:
    """Refuse what trimesh would misread, and counts beyond the buffers, before any memory is asked for."""
    version = str(header["asset"].get("version", "2.0"))
    if version.partition(".")[0] != "2":
        raise FormatError(f"is glTF {version}, which cannot be read; export it as glTF 2.0")
    for extension, method in _COMPRESSIONS.items():
        if extension in header.get("extensionsRequired", []):
            raise FormatError(
                f"is compressed with {method}, which cannot be read; export it without compression"
            )
    accessors = header.get("accessors", [])
    for index, accessor in enumerate(accessors):
        _check_accessor(header, index, accessor)
    faces_of_mesh = []
    for mesh in header.get("meshes", []):
        faces = 0
        for primitive in mesh["primitives"]:
            mode = primitive.get("mode", _TRIANGLES)
            if mode == _TRIANGLE_FAN:
                raise FormatError("has triangle fans, which cannot be read; export it with plain triangles")
            if mode not in (_TRIANGLES, _TRIANGLE_STRIP):
                continue  # points and lines
            positions = accessors[primitive["attributes"]["POSITION"]]
            indices = accessors[primitive["indices"]] if "indices" in primitive else positions
            for accessor in (positions, indices):
                if "sparse" in accessor or "bufferView" not in accessor:
                    raise FormatError("has sparse positions or indices, which cannot be read; export it anew")
            if positions.get("normalized"):
                raise FormatError(
                    "has normalised positions, which cannot be read; export it without quantisation"
                )
            faces += indices["count"] // 3 if mode == _TRIANGLES else max(indices["count"] - 2, 0)
        faces_of_mesh.append(faces)
    # A mesh may stand in the scene many times.
    placed = sum(faces_of_mesh[node["mesh"]] for node in header.get("nodes", []) if "mesh" in node)
    check_face_count(max(placed, sum(faces_of_mesh)), max_faces)
    _check_tree(header)


def _check_accessor(header: dict[str, Any], index: int, accessor: dict[str, Any]) -> None:
    item = _COMPONENT_BYTES[accessor["componentType"]] * _COMPONENTS[accessor["type"]]
    count, offset = accessor["count"], accessor.get("byteOffset", 0)
    if "bufferView" not in accessor:
        # Zeros, later replaced; trimesh makes room for them.
        available = sum(buffer["byteLength"] for buffer in header.get("buffers", []))
        stride = item
    else:
        view = header["bufferViews"][accessor["bufferView"]]
        stride = view.get("byteStride", item)
        available = view["byteLength"]
        buffer = header["buffers"][view["buffer"]]
        if view.get("byteOffset", 0) < 0 or view.get("byteOffset", 0) + available > buffer["byteLength"]:
            raise FormatError(f"has a view beyond the end of its buffer (accessor {index}); it is damaged")
    if (
        count < 0
        or offset < 0
        or stride < item
        or (count and offset + (count - 1) * stride + item > available)
    ):
        raise FormatError(
            f"claims {count:,} values of {item} bytes in accessor {index}, but its buffer has "
            f"{available:,}; it is damaged or was cut short: copy or export it again"
        )


def _check_tree(header: dict[str, Any]) -> None:
    """Refuse nodes in two places: trimesh would keep one of them, and a circle has no place at all."""
    places = [child for node in header.get("nodes", []) for child in node.get("children", [])]
    # A node may be the root of several scenes.
    places += {root for scene in header.get("scenes", []) for root in scene.get("nodes", [])}
    if len(set(places)) < len(places):
        raise FormatError("has a node with two parents, which glTF does not allow; export it again")


def _flatten(scene: Any) -> Geometry:
    """Put every geometry of a trimesh scene in its place and all of them in one list."""
    vertices, faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    if scene.graph.nodes_geometry:
        placed = [scene.graph[node] for node in sorted(scene.graph.nodes_geometry)]
    else:  # a file without a scene; its meshes have no place
        placed = [(np.eye(4), name) for name in scene.geometry]
    for transform, name in placed:
        geometry = scene.geometry[name]
        if not hasattr(geometry, "vertices") or len(np.shape(geometry.vertices)) != 2:
            continue
        triangles = np.asarray(getattr(geometry, "faces", np.empty((0, 3))), np.int64)
        if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(geometry.vertices)):
            raise FormatError(
                f"has a face that names none of the {len(geometry.vertices):,} vertices of its part; "
                "it is damaged"
            )
        vertices.append(np.asarray(geometry.vertices, np.float64) @ transform[:3, :3].T + transform[:3, 3])
        mirrored = np.linalg.det(transform[:3, :3]) < 0
        faces.append((triangles[:, ::-1] if mirrored else triangles) + count)
        count += len(vertices[-1])
    return np.concatenate(vertices), np.concatenate(faces)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep trimesh's log and numpy's warnings off the user's terminal; what matters is raised."""
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(level)
