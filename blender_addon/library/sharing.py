# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects show the same evaluated mesh, and so are placements of one shape.

It imports nothing but Python's own modules, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Iterable
from typing import Any, Generic, TypeVar

__all__ = ["SharedMeshes"]

Entry = TypeVar("Entry")

# Relative difference of lengths and angles that count as equal: float32 matrices carry about seven digits.
SAME_SHAPE = 1e-5
# Share of the cube of its length that the volume of a matrix must have: flat ones lose a direction.
LEAST_VOLUME = 1e-9
# Types of parents that deform their children, as a modifier would.
DEFORMING_PARENTS = {"ARMATURE", "LATTICE", "CURVE"}


class SharedMeshes(Generic[Entry]):
    """Entries by the mesh that objects show: their data, its content once evaluated, and how it is stretched.

    Objects of one mesh datablock are one entry if they are evaluated alike (whatever modifiers, shape keys or
    parents do) and one is moved, turned, mirrored or uniformly scaled to where the other is.

    Parameters
    ----------
    objects : iterable of bpy.types.Object
        All that are going to be read.
    """

    def __init__(self, objects: Iterable[Any]) -> None:
        self._users = Counter(item.data.session_uid for item in objects)
        self._plain: dict[int, bytes] = {}
        self._entries: dict[tuple[int, bytes], list[tuple[list[float], Entry]]] = {}

    def is_shared(self, item: Any) -> bool:
        """Whether other objects have the same data."""
        return self._users[item.data.session_uid] > 1

    def content(self, item: Any) -> bytes | None:
        """Return the content that an object shows if that is known without evaluating it, else None."""
        return self._plain.get(item.data.session_uid) if is_plain(item) else None

    def read(self, item: Any, *arrays: Any) -> bytes:
        """Remember the content that an object shows.

        Parameters
        ----------
        item : bpy.types.Object
        *arrays : buffers
            Its evaluated coordinates and faces, in its own space.

        Returns
        -------
        content : bytes
            A digest of them; empty for an object that shares its data with no other.
        """
        if not self.is_shared(item):
            return b""
        digest = hashlib.blake2b(digest_size=16)
        for values in arrays:
            digest.update(len(values).to_bytes(8, "little"))
            digest.update(values)
        if is_plain(item):
            self._plain[item.data.session_uid] = digest.digest()
        return digest.digest()

    def find(self, item: Any, matrix: Any, content: bytes) -> Entry | None:
        """Return the entry that an object is a placement of; None if it needs one of its own.

        Parameters
        ----------
        item : bpy.types.Object
        matrix : mathutils.Matrix
            Its world matrix, once evaluated.
        content : bytes
            From `content` or `read`.
        """
        own = _stretch(matrix)
        if own is None or not content:
            return None
        for stretch, entry in self._entries.get((item.data.session_uid, content), ()):
            if all(abs(one - other) <= SAME_SHAPE for one, other in zip(own, stretch, strict=True)):
                return entry
        return None

    def put(self, item: Any, matrix: Any, content: bytes, entry: Entry) -> None:
        """Add an entry whose first placement is an object."""
        own = _stretch(matrix)
        if own is not None and content:
            self._entries.setdefault((item.data.session_uid, content), []).append((own, entry))


def is_plain(item: Any) -> bool:
    """Whether an object is seen as its data alone, which need not be evaluated for each object then."""
    # In old files a parent deforms its children without any modifier.
    deformed = item.parent is not None and item.parent_type in DEFORMING_PARENTS
    return not item.modifiers and getattr(item.data, "shape_keys", None) is None and not deformed


def _stretch(matrix: Any) -> list[float] | None:
    """Lengths and angles of the axes, relative to their size; None for a flat or broken matrix.

    Two matrices have the same exactly if one is the other after a motion with a uniform scale, mirroring or
    not: it is AᵀA / tr(AᵀA) of the linear part A.
    """
    axes = [matrix.col[index].to_3d() for index in range(3)]
    size = sum(axis.length_squared for axis in axes)
    if not (math.isfinite(size) and size > 0):
        return None
    if abs(axes[0].dot(axes[1].cross(axes[2]))) <= LEAST_VOLUME * size**1.5:
        return None
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return [axes[one].dot(axes[other]) / size for one, other in pairs]
