# SPDX-License-Identifier: MIT
"""A box in the files of all formats, and what is asserted of files."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pytest

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.mesh.mesh import FloatArray

Points = FloatArray
Faces = Sequence[Sequence[int]]


class Writer(Protocol):
    """Makes the bytes of a file."""

    def __call__(self, points: Points = ..., faces: Faces = ...) -> bytes: ...


POINTS = np.array(
    [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 3], [2, 0, 3], [2, 1, 3], [0, 1, 3]], np.float64
)
QUADS: Faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 5), (3, 0, 4, 7)]
TRIANGLES: Faces = [(a, b, c) for a, b, c, d in QUADS for a, b, c in ((a, b, c), (a, c, d))]
MIXED: Faces = [*QUADS[:3], *TRIANGLES[6:]]
AREA = 2 * (2 * 1 + 2 * 3 + 1 * 3)
VOLUME = 6.0


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def obj(points: Points = POINTS, faces: Faces = TRIANGLES) -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    return ("# a box\n" + "\n".join(lines) + "\n").encode()


def off(points: Points = POINTS, faces: Faces = TRIANGLES, first: str = "OFF") -> bytes:
    lines = [first, f"{len(points)} {len(faces)} 0", *(f"{x} {y} {z}" for x, y, z in points)]
    lines += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def ply(
    points: Points = POINTS,
    faces: Faces = TRIANGLES,
    kind: str = "binary_little_endian",
    corners: str = "vertex_indices",
) -> bytes:
    header = [
        "ply",
        f"format {kind} 1.0",
        "comment made by a test",
        f"element vertex {len(points)}",
        *(f"property float {axis}" for axis in "xyz"),
        "property uchar red",
        f"element face {len(faces)}",
        "property uchar flags",
        f"property list uchar int {corners}",
        "end_header",
    ]
    data = ("\n".join(header) + "\n").encode()
    if kind == "ascii":
        rows = [f"{x} {y} {z} 7" for x, y, z in points]
        rows += [f"1 {len(face)} " + " ".join(map(str, face)) for face in faces]
        return data + ("\n".join(rows) + "\n").encode()
    order = "<" if kind == "binary_little_endian" else ">"
    data += b"".join(struct.pack(order + "3fB", *point, 7) for point in points)
    return data + b"".join(struct.pack(f"{order}BB{len(face)}i", 1, len(face), *face) for face in faces)


def stl(points: Points = POINTS, faces: Faces = TRIANGLES) -> bytes:
    data = b"a box".ljust(80) + struct.pack("<I", len(faces))
    return data + b"".join(struct.pack("<12fH", 0, 0, 0, *points[list(face)].ravel(), 0) for face in faces)


def stl_text(points: Points = POINTS, faces: Faces = TRIANGLES) -> bytes:
    lines = ["solid box"]
    for face in faces:
        lines += ["facet normal 0 0 0", " outer loop"]
        lines += [f"  vertex {x} {y} {z}" for x, y, z in points[list(face)]]
        lines += [" endloop", "endfacet"]
    return ("\n".join([*lines, "endsolid box"]) + "\n").encode()


def gltf_tree(
    points: Points = POINTS, faces: Faces = TRIANGLES, uri: str | None = None
) -> tuple[dict[str, Any], bytes]:
    """The JSON part and the buffer of a glTF with one mesh in one node."""
    position = np.asarray(points, "<f4").tobytes()
    index = np.array(faces, "<u2").tobytes()
    buffer: dict[str, Any] = {"byteLength": len(position) + len(index)}
    if uri is not None:
        buffer["uri"] = uri
    tree: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3 * len(faces), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(position)},
            {"buffer": 0, "byteOffset": len(position), "byteLength": len(index)},
        ],
        "buffers": [buffer],
    }
    return tree, position + index


def gltf(points: Points = POINTS, faces: Faces = TRIANGLES, **changes: Any) -> bytes:
    tree, data = gltf_tree(points, faces)
    tree["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps(tree | changes).encode()


def glb(points: Points = POINTS, faces: Faces = TRIANGLES, **changes: Any) -> bytes:
    tree, data = gltf_tree(points, faces)
    text = json.dumps(tree | changes).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


FILES = {
    "box.obj": obj(),
    "box.off": off(),
    "box.ply": ply(),
    "box_big.ply": ply(kind="binary_big_endian"),
    "box_text.ply": ply(kind="ascii"),
    "box.stl": stl(),
    "box_text.stl": stl_text(),
    "box.gltf": gltf(),
    "box.glb": glb(),
}


def write(folder: Path, name: str, data: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


def refuse(path: Path, *words: str, **options: Any) -> None:
    """The file is refused with an error that names it and says these words."""
    with pytest.raises(MeshError) as caught:
        read_mesh(path, **options)
    message = str(caught.value)
    assert path.name in message
    for word in words:
        assert word in message
