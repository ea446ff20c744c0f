# SPDX-License-Identifier: MIT
"""Copies of glTF files without animations: Blender would show the first frame of one, not the nodes."""

from __future__ import annotations

import json
import struct
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

__all__ = ["SUFFIXES", "without_animations"]

SUFFIXES = frozenset({".glb", ".gltf"})

_HEADER = struct.Struct("<4sIIII")
_JSON = 0x4E4F534A


def without_animations(path: Path, folder: Path) -> Path:
    """Copy a glTF file without its animations.

    Parameters
    ----------
    path : Path
        A .gltf or .glb file.
    folder : Path
        For the copy, which refers to the other files of the original.

    Returns
    -------
    copy : Path
        The file itself if it has no animations, or is damaged.
    """
    with suppress(OSError, ValueError, struct.error, TypeError, AttributeError):
        data = path.read_bytes()
        text, rest = data, b""
        if path.suffix.lower() == ".glb":
            size = _HEADER.unpack_from(data)[3]
            text, rest = data[_HEADER.size : _HEADER.size + size], data[_HEADER.size + size :]
        tree: dict[str, Any] = json.loads(text)
        if not tree.pop("animations", None):
            return path
        for item in [*tree.get("buffers", []), *tree.get("images", [])]:
            if "uri" in item and not item["uri"].startswith("data:"):
                item["uri"] = quote(str((path.parent / unquote(item["uri"])).absolute()))
        content = json.dumps(tree).encode()
        content += b" " * (-len(content) % 4)
        copy = folder / path.name
        if path.suffix.lower() == ".glb":
            whole = _HEADER.size + len(content) + len(rest)
            content = _HEADER.pack(b"glTF", 2, whole, len(content), _JSON) + content + rest
        copy.write_bytes(content)
        return copy
    return path
