# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether two materials look the same, whatever they are called.

Whoever appends an asset twice has its materials twice: Wood and Wood.001.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from typing import Any

import bpy

__all__ = ["Materials"]

# What Blender appends to a name that is taken.
_NUMBER = re.compile(r"\.\d{3,}$")
# Properties that say how data is organised or shown in editors, not what it looks like.
_OUTSIDE = frozenset(
    (
        # of data in general
        *(
            "rna_type",
            "name",
            "name_full",
            "original",
            "library",
            "parent",
            "id_type",
            "session_uid",
            "users",
            "tag",
        ),
        *(
            "is_evaluated",
            "is_embedded_data",
            "is_missing",
            "is_runtime_data",
            "is_editable",
            "is_library_indirect",
        ),
        *("use_fake_user", "use_extra_user", "is_icon_custom"),
        # of nodes, sockets and their trees
        *(
            "location",
            "location_absolute",
            "width",
            "height",
            "dimensions",
            "select",
            "hide",
            "warning_propagation",
        ),
        *("show_options", "show_preview", "show_texture", "show_expanded", "is_linked", "is_inactive"),
        *("is_icon_visible", "is_panel_collapsed", "display_shape", "link_limit"),
    )
)
# Parts that are looked into: others lead back to where one came from.
_PARTS = frozenset(
    (
        *("node_tree", "nodes", "inputs", "links", "color_ramp", "elements", "mapping", "curves", "points"),
        *("texture_mapping", "color_mapping", "image_user", "cycles"),
    )
)


class Materials:
    """Compares materials of a file that does not change meanwhile."""

    def __init__(self) -> None:
        self._digests: dict[Any, bytes] = {}

    def are_same(self, first: Sequence[Any], second: Sequence[Any]) -> bool:
        """Compare the materials of two meshes, slot by slot.

        Parameters
        ----------
        first, second : sequence of bpy.types.Material or None

        Returns
        -------
        same : bool
            Whether they are the same ones, or copies of each other.
        """
        return len(first) == len(second) and all(map(self._are_copies, first, second))

    def _are_copies(self, first: Any, second: Any) -> bool:
        if first == second:
            return True
        if first is None or second is None or _stem(first.name) != _stem(second.name):
            return False
        return self._digest(first) == self._digest(second)

    def _digest(self, block: Any) -> bytes:
        """Hash of all that a material, a group of nodes or an image consists of."""
        if block not in self._digests:
            # For a block that contains itself.
            self._digests[block] = str(block.session_uid).encode()
            text = repr(self._content(block))
            self._digests[block] = hashlib.blake2b(text.encode(), digest_size=16).digest()
        return self._digests[block]

    def _content(self, value: Any) -> Any:
        """Return what a block or a part of it consists of, as values that can be printed."""
        if isinstance(value, bpy.types.NodeLink):
            ends = (value.from_node, value.to_node), (value.from_socket, value.to_socket)
            return [node.name for node in ends[0]], [socket.identifier for socket in ends[1]]
        if getattr(value, "animation_data", None) is not None:
            return "animated", value.session_uid
        if isinstance(value, bpy.types.Image):
            if value.source == "GENERATED" or value.is_dirty:
                return "drawn", value.session_uid
            # Appended from different places, the same file has different relative paths.
            packed = [hashlib.blake2b(file.packed_file.data).digest() for file in value.packed_files]
            own = packed or bpy.path.abspath(value.filepath, library=value.library)
            return own, value.colorspace_settings.name, value.alpha_mode
        own_name = value.name if isinstance(value, bpy.types.Node) else ""
        entries = [entry for entry in value.bl_rna.properties if entry.identifier not in _OUTSIDE]
        return type(value).__name__, own_name, [self._value(value, entry) for entry in entries]

    def _value(self, owner: Any, entry: Any) -> Any:
        name, kind = entry.identifier, entry.type
        if kind == "COLLECTION":
            return (name, [self._content(item) for item in getattr(owner, name)]) if name in _PARTS else None
        if kind != "POINTER":
            value = getattr(owner, name)
            return name, tuple(value) if getattr(entry, "is_array", False) else value
        value = getattr(owner, name)
        # Of other data there are only pointers back to where one came from, and what editors show.
        if not isinstance(value, bpy.types.ID) and name not in _PARTS:
            return None
        # The nodes of a material belong to it; a group of nodes is a block of its own.
        is_own = name == "node_tree" and isinstance(owner, bpy.types.Material)
        if isinstance(value, bpy.types.ID) and not is_own:
            is_read = isinstance(value, (bpy.types.NodeTree, bpy.types.Image, bpy.types.Material))
            return name, self._digest(value) if is_read else value.session_uid
        return None if value is None else (name, self._content(value))


def _stem(name: str) -> str:
    return _NUMBER.sub("", name)
