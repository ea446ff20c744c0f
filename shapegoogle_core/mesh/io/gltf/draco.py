# SPDX-License-Identifier: MIT
"""Primitives of a glTF that are compressed with Draco, decoded by DracoPy where it is installed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError
from shapegoogle_core.mesh.io.gltf.accessors import component_type, normalised
from shapegoogle_core.mesh.io.gltf.container import Document
from shapegoogle_core.mesh.io.gltf.extensions import DRACO
from shapegoogle_core.mesh.io.gltf.json_object import JsonObject

__all__ = ["DracoPrimitive"]


@dataclass(frozen=True, eq=False)
class DracoPrimitive:
    """A decoded primitive.

    Parameters
    ----------
    faces : (m, 3) array of int
    """

    faces: NDArray[np.int64]
    _decoded: Any
    _document: Document
    _attributes: JsonObject
    _numbers: JsonObject

    @classmethod
    def decode(cls, document: Document, primitive: JsonObject) -> DracoPrimitive:
        """Decode the triangles of a primitive; `FormatError` without the package, or if they are damaged."""
        try:
            import DracoPy
        except ImportError as error:
            raise FormatError(
                f"is compressed with Draco ({DRACO}), which needs the package DracoPy: install it "
                "(pip install DracoPy), or export the file without compression"
            ) from error
        extension = primitive.object("extensions").object(DRACO)
        view = document.item("bufferViews", extension.whole("bufferView"), extension)
        data = bytes(document.bytes_of(view))
        try:
            decoded = DracoPy.decode(data)
        except (ValueError, RuntimeError, DracoPy.FileTypeException) as error:
            raise DamagedError(f"has Draco data in {extension.place} that cannot be decoded") from error
        faces = getattr(decoded, "faces", np.empty((0, 3)))
        return cls(
            np.asarray(faces, np.int64).reshape(-1, 3),
            decoded,
            document,
            primitive.object("attributes"),
            extension.object("attributes"),
        )

    def values(self, name: str) -> NDArray[Any]:
        """Return an attribute, such as "POSITION"."""
        found = self._decoded.get_attribute_by_unique_id(self._numbers.whole(name))
        if found is None:
            raise DamagedError(f"has no attribute {name} in the Draco data of {self._numbers.place}")
        accessor = self._document.item("accessors", self._attributes.whole(name), self._attributes)
        # Draco stores whole numbers with more bits than the accessor, which says what they stand for.
        return normalised(np.asarray(found["data"]).astype(component_type(accessor)), accessor)
