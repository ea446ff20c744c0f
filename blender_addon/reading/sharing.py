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
# Modifiers whose result depends on the mesh and their own settings alone, if these name no other object.
# Simulations and geometry nodes may depend on the object and the time as well.
SETTLED = {
    *("ARRAY", "BEVEL", "DECIMATE", "EDGE_SPLIT", "MIRROR", "MULTIRES", "REMESH", "SMOOTH", "SOLIDIFY"),
    *("SUBSURF", "TRIANGULATE", "WEIGHTED_NORMAL", "WELD", "WIREFRAME"),
}
# What modifiers say about themselves that has no effect on the mesh.
LABELS = {
    *("name", "execution_time", "is_active", "is_override_data", "persistent_uid", "show_expanded"),
    *("show_in_editmode", "show_on_cage", "show_render", "use_pin_to_last"),
}
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
        self._users = Counter(_number(item) for item in objects)
        self._known: dict[tuple[Any, ...], bytes] = {}
        self._entries: dict[tuple[Any, ...], list[tuple[list[float], Entry]]] = {}

    def is_shared(self, item: Any) -> bool:
        """Whether other objects have the same data."""
        return self._users[_number(item)] > 1

    def content(self, item: Any) -> bytes | None:
        """Return the content that an object shows if that is known without its mesh, else None.

        Parameters
        ----------
        item : bpy.types.Object
            Evaluated.
        """
        recipe = _recipe(item)
        return None if recipe is None else self._known.get(recipe)

    def read(self, item: Any, *arrays: Any) -> bytes:
        """Remember the content that an object shows.

        Parameters
        ----------
        item : bpy.types.Object
            Evaluated.
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
        recipe = _recipe(item)
        if recipe is not None:
            self._known[recipe] = digest.digest()
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
        return self.find_by((_number(item), content), matrix) if content else None

    def put(self, item: Any, matrix: Any, content: bytes, entry: Entry) -> None:
        """Add an entry whose first placement is an object."""
        if content:
            self.put_by((_number(item), content), matrix, entry)

    def find_by(self, key: tuple[Any, ...], matrix: Any) -> Entry | None:
        """Return the entry of something with a key that is stretched as a matrix says, or None."""
        own = _stretch(matrix)
        if own is None:
            return None
        for stretch, entry in self._entries.get(key, ()):
            if all(abs(one - other) <= SAME_SHAPE for one, other in zip(own, stretch, strict=True)):
                return entry
        return None

    def put_by(self, key: tuple[Any, ...], matrix: Any, entry: Entry) -> None:
        """Add an entry under a key; see `find_by`."""
        own = _stretch(matrix)
        if own is not None:
            self._entries.setdefault(key, []).append((own, entry))


def _recipe(item: Any) -> tuple[Any, ...] | None:
    """Describe all that the mesh of an evaluated object is made from; None if that is more than can be told.

    Blender computes the modifiers of each object anew, also if all show the same.
    """
    # In old files a parent deforms its children without any modifier.
    deformed = item.parent is not None and item.parent_type in DEFORMING_PARENTS
    # Curves and the like may follow other objects.
    known = item.type in ("MESH", "POINTCLOUD")
    if deformed or not known or getattr(item.original.data, "shape_keys", None) is not None:
        return None
    recipe: list[Any] = [_number(item)]
    for modifier in item.modifiers:
        if not modifier.show_viewport:
            continue
        if modifier.type not in SETTLED:
            return None
        recipe.append(modifier.type)
        for entry in modifier.bl_rna.properties:
            if entry.identifier in LABELS or entry.identifier == "rna_type":
                continue
            value = getattr(modifier, entry.identifier)
            if entry.type == "COLLECTION":
                return None
            if entry.type == "POINTER":
                # A profile of its own is there also where it is not used.
                unused = entry.identifier == "custom_profile" and modifier.profile_type != "CUSTOM"
                if value is not None and not unused:
                    return None
            elif entry.type == "ENUM" and entry.is_enum_flag:
                recipe.append(frozenset(value))
            else:
                recipe.append(tuple(value) if getattr(entry, "is_array", False) else value)
    return tuple(recipe)


def _number(item: Any) -> int:
    """Session number of an object's data, also of an evaluated object."""
    return int(item.original.data.session_uid)


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
