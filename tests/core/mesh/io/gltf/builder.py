# SPDX-License-Identifier: MIT
"""Small glTF files, put together piece by piece."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.mesh import Mesh, read_mesh
from tests.core.mesh.io.mesh_files import POINTS, TRIANGLES

__all__ = ["BOX", "TRIANGLE", "GltfBuilder"]

BOX = POINTS.astype(np.float32)
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
"""Four points, for primitives that name three or all of them."""

_COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class GltfBuilder:
    """A glTF in one buffer. Lists that stay empty are not written."""

    def __init__(self) -> None:
        self.data = b""
        self.tree: dict[str, Any] = {"asset": {"version": "2.0"}, "buffers": [{}]}

    def add(self, kind: str, **values: Any) -> int:
        """Append an object to a list such as "nodes"; return its index."""
        items = self.tree.setdefault(kind, [])
        items.append(values)
        return len(items) - 1

    def view(self, data: bytes, **values: Any) -> int:
        """Append bytes and their buffer view."""
        self.data += b"\0" * (-len(self.data) % 4)
        offset = len(self.data)
        self.data += data
        return self.add("bufferViews", buffer=0, byteOffset=offset, byteLength=len(data), **values)

    def accessor(self, values: ArrayLike, dtype: str = "f4", **more: Any) -> int:
        """Append an array and its accessor."""
        array = np.asarray(values, "<" + dtype)
        view = self.view(array.tobytes())
        return self.accessor_of(view, array, **more)

    def accessor_of(self, view: int | None, array: NDArray[Any], **more: Any) -> int:
        """Append an accessor of a view, or of none, with the shape and type of an array."""
        width = 1 if array.ndim == 1 else array.shape[1]
        values = {
            "componentType": _COMPONENTS[array.dtype.str[1:]],
            "count": len(array),
            "type": _KINDS[width],
            **({} if view is None else {"bufferView": view}),
        }
        return self.add("accessors", **(values | more))

    def mesh(self, points: ArrayLike = BOX, faces: Any = TRIANGLES, **more: Any) -> int:
        """Append a mesh of one primitive; no indices if faces is None."""
        attributes = {"POSITION": self.accessor(points)}
        primitive = {"attributes": attributes | more.pop("attributes", {})}
        if faces is not None:
            primitive["indices"] = self.accessor(np.ravel(faces), more.pop("index", "u2"))
        mesh = {key: more.pop(key) for key in ("weights",) if key in more}
        return self.add("meshes", primitives=[primitive | more], **mesh)

    def scene(self, *nodes: int) -> int:
        """Append a scene."""
        return self.add("scenes", nodes=list(nodes))

    def glb(self) -> bytes:
        """Write it as one binary file."""
        data = self.data + b"\0" * (-len(self.data) % 4)
        tree = json.loads(json.dumps(self.tree))
        tree["buffers"][0]["byteLength"] = len(data)
        text = json.dumps(tree).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(data), 0x004E4942) + data
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def gltf(self) -> bytes:
        """Write it as a text with its buffer inside."""
        tree = json.loads(json.dumps(self.tree))
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        tree["buffers"][0] |= {"byteLength": len(self.data), "uri": uri}
        return json.dumps(tree).encode()

    def save(self, folder: Path, name: str = "a.glb") -> Path:
        """Write it into a folder, in the form that the suffix says."""
        path = folder / name
        path.write_bytes(self.glb() if name.endswith(".glb") else self.gltf())
        return path

    def read(self, folder: Path) -> Mesh:
        """Write it and read it, in both forms; these give the same."""
        mesh, text = (read_mesh(self.save(folder, name)) for name in ("a.glb", "a.gltf"))
        assert np.array_equal(mesh.vertices, text.vertices)
        assert np.array_equal(mesh.faces, text.faces)
        return mesh
