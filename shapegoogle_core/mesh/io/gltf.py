# SPDX-License-Identifier: MIT
"""What a glTF must pass before trimesh parses it: trimesh 5.2 ignores or misreads what is refused here."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from shapegoogle_core.mesh.io.ply import Checked, FormatError, check_face_count

__all__ = ["check_glb", "check_gltf"]

_COMPRESSIONS = {"KHR_draco_mesh_compression": "Draco", "EXT_meshopt_compression": "meshopt"}
_TRIANGLES, _TRIANGLE_STRIP, _TRIANGLE_FAN = 4, 5, 6


def check_glb(data: bytes, max_faces: int) -> Checked:
    """Compare the lengths that a .glb file claims with its own, then check it as `check_gltf` does."""
    magic, version, length, json_length = np.frombuffer(data[:16].ljust(16, b"\0"), "<u4").tolist()
    if magic != int.from_bytes(b"glTF", "little") or version != 2:
        raise FormatError("does not begin like a binary glTF 2 file (.glb); export it again")
    if length > len(data) or 20 + json_length > length:
        raise FormatError(
            f"claims {length:,} bytes, {json_length:,} of them JSON, but has {len(data):,}; "
            "it is damaged or was cut short: copy or export it again"
        )
    check_gltf(data[20 : 20 + json_length], max_faces)
    return Checked(data, None)


def check_gltf(data: bytes, max_faces: int) -> Checked:
    """Check the JSON of a glTF: version, compression, counts, one place for each node."""
    try:
        header = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise FormatError(
            f"holds no valid JSON ({error}); it is damaged, cut short or no glTF file"
        ) from error
    if not isinstance(header, dict) or "asset" not in header:
        raise FormatError("has no 'asset' entry, so it is no glTF file; export it again")
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
            raise FormatError(
                f"claims {accessor['count']:,} values in accessor {index}, which is no count or too many; "
                "it is damaged: export it again, or raise max_faces"
            )
    places = [child for node in header.get("nodes", []) for child in node.get("children", [])]
    # A node may be the root of several scenes.
    places += {root for scene in header.get("scenes", []) for root in scene.get("nodes", [])}
    if len(set(places)) < len(places):
        raise FormatError("has a node with two parents, which glTF does not allow; export it again")
    return Checked(data, None)


def _face_count(header: dict[str, Any], primitive: dict[str, Any]) -> int:
    mode = primitive.get("mode", _TRIANGLES)
    if mode == _TRIANGLE_FAN:
        raise FormatError("has triangle fans, which cannot be read; export it with plain triangles")
    if mode not in (_TRIANGLES, _TRIANGLE_STRIP):
        return 0  # points and lines
    positions = header["accessors"][primitive["attributes"]["POSITION"]]
    corners = header["accessors"][primitive["indices"]] if "indices" in primitive else positions
    if any("sparse" in accessor or "bufferView" not in accessor for accessor in (positions, corners)):
        raise FormatError("has sparse positions or indices, which cannot be read; export it anew")
    if positions.get("normalized"):
        raise FormatError("has normalised positions, which cannot be read; export it without quantisation")
    count: int = corners["count"]
    return count // 3 if mode == _TRIANGLES else max(count - 2, 0)
