# SPDX-License-Identifier: MIT
"""Reading glTF, text and binary: checked here, parsed by trimesh, all nodes in their places.

trimesh 5.2 ignores or misreads the features that are refused here.
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
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_face_count, read_content
from shapegoogle_core.mesh.io.polygons import Polygons

__all__ = ["read_glb", "read_gltf"]

_COMPRESSIONS = {"KHR_draco_mesh_compression": "Draco", "EXT_meshopt_compression": "meshopt"}
_TRIANGLES, _TRIANGLE_STRIP, _TRIANGLE_FAN = 4, 5, 6


def read_glb(file: MeshFile) -> Polygons:
    """Read a binary glTF file; see `read_gltf`."""
    data = file.data
    magic, version, length, json_length = np.frombuffer(data[:16].ljust(16, b"\0"), "<u4").tolist()
    if magic != int.from_bytes(b"glTF", "little") or version != 2:
        raise FormatError("does not begin like a binary glTF 2 file (.glb); export it again")
    if length > len(data) or 20 + json_length > length:
        raise DamagedError(f"claims {length:,} bytes, {json_length:,} of them JSON, but has {len(data):,}")
    _check(data[20 : 20 + json_length], file.max_faces)
    return _parse(file, "glb")


def read_gltf(file: MeshFile) -> Polygons:
    """Read a glTF file with the buffers that it names.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    polygons : Polygons
        The meshes of all nodes, each in its place.

    Raises
    ------
    FormatError
        If the file is damaged, needs a file that is not in its folder, uses a feature that cannot be read,
        or has too many faces.
    """
    _check(file.data, file.max_faces)
    return _parse(file, "gltf")


def _check(data: bytes, max_faces: int) -> None:
    """Check the JSON of a glTF: version, compression, counts, one place for each node."""
    try:
        header = json.loads(data)
    except (ValueError, RecursionError) as error:
        place = (
            f" at line {error.lineno}, column {error.colno}"
            if isinstance(error, json.JSONDecodeError)
            else ""
        )
        raise DamagedError(f"has no valid JSON{place}") from error
    if not isinstance(header, dict) or "asset" not in header:
        raise FormatError("has no 'asset' entry, so it is not a glTF file; export it again")
    version = str(header["asset"].get("version", "2.0"))
    if version.partition(".")[0] != "2":
        raise FormatError(f"is glTF {version}, which cannot be read; export it as glTF 2.0")
    for extension in header.get("extensionsRequired", []):
        if extension in _COMPRESSIONS:
            raise FormatError(
                f"is compressed with {_COMPRESSIONS[extension]}, which cannot be read; export it without"
            )
    face_counts = [
        sum(_face_count(header, primitive) for primitive in mesh["primitives"])
        for mesh in header.get("meshes", [])
    ]
    # A mesh may stand in the scene many times.
    placed = sum(face_counts[node["mesh"]] for node in header.get("nodes", []) if "mesh" in node)
    check_face_count(max(placed, sum(face_counts)), max_faces)
    for index, accessor in enumerate(header.get("accessors", [])):
        # trimesh makes room for accessors without a buffer, whatever they claim.
        if not 0 <= accessor["count"] <= max(3 * max_faces, 10_000_000):
            raise DamagedError(
                f"claims {accessor['count']:,} values in accessor {index}, a number out of range"
            )
    places = [child for node in header.get("nodes", []) for child in node.get("children", [])]
    # A node may be the root of several scenes.
    places += {root for scene in header.get("scenes", []) for root in scene.get("nodes", [])}
    if len(set(places)) < len(places):
        raise FormatError("has a node with two parents, which glTF does not allow; export it again")


def _face_count(header: dict[str, Any], primitive: dict[str, Any]) -> int:
    mode = primitive.get("mode", _TRIANGLES)
    if mode == _TRIANGLE_FAN:
        raise FormatError("has triangle fans, which cannot be read; export it with plain triangles")
    if mode not in (_TRIANGLES, _TRIANGLE_STRIP):
        return 0  # points and lines
    positions = header["accessors"][primitive["attributes"]["POSITION"]]
    corners = header["accessors"][primitive["indices"]] if "indices" in primitive else positions
    if any("sparse" in accessor or "bufferView" not in accessor for accessor in (positions, corners)):
        raise FormatError("has sparse positions or indices, which cannot be read; export it again")
    if positions.get("normalized"):
        raise FormatError("has normalised positions, which cannot be read; export it without quantisation")
    count: int = corners["count"]
    return count // 3 if mode == _TRIANGLES else max(count - 2, 0)


def _parse(file: MeshFile, kind: str) -> Polygons:
    import trimesh  # takes a second

    neighbours: Any = _Neighbours(file.folder, file.max_faces)
    with _quiet():
        scene = trimesh.load_scene(
            io.BytesIO(file.data),
            file_type=kind,
            resolver=neighbours,
            process=False,
            maintain_order=True,
            skip_materials=True,
        )
        return Polygons.from_triangles(*_flatten(scene))


def _flatten(scene: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Put all parts of a trimesh scene in their places and into one list of triangles."""
    vertices, faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    if scene.graph.nodes_geometry:
        placed = [scene.graph[node] for node in sorted(scene.graph.nodes_geometry)]
    else:  # a glTF without a scene; its meshes have no place
        placed = [(np.eye(4), name) for name in scene.geometry]
    for transform, name in placed:
        part = scene.geometry[name]
        points = np.asarray(part.vertices, np.float64)
        triangles = np.asarray(getattr(part, "faces", ()), np.int64).reshape(-1, 3)
        if triangles.size and (triangles.min() < 0 or triangles.max() >= len(points)):
            strange = triangles[(triangles < 0) | (triangles >= len(points))][0]
            raise DamagedError(
                f"has a face that names vertex {strange}, counted from 0, of the {len(points):,} of its part"
            )
        if not np.array_equal(transform, np.eye(4)):
            points = points @ transform[:3, :3].T + transform[:3, 3]
        vertices.append(points)
        mirrored = np.linalg.det(transform[:3, :3]) < 0
        faces.append((triangles[:, ::-1] if mirrored else triangles) + count)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(faces)


class _Neighbours:
    """Resolver of the other files that a glTF names: only regular files in its folder or below."""

    def __init__(self, folder: Path, max_faces: int) -> None:
        self.folder = folder.resolve()
        self.max_faces = max_faces

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def get(self, name: str) -> bytes:
        neighbour = (self.folder / unquote(name)).resolve()
        if not neighbour.is_relative_to(self.folder) or not neighbour.is_file():
            raise FormatError(f"needs the file {name!r}, which is not beside it; copy both together")
        return read_content(neighbour, self.max_faces)


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress trimesh's log and numpy's warnings; errors are raised all the same."""
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(level)
