# SPDX-License-Identifier: GPL-3.0-or-later
"""The vertex that heat spreads from: which one of those selected, and how to choose one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bmesh

from ..translation import counted, tr

__all__ = ["Picked", "picked", "picked_text"]


@dataclass(frozen=True)
class Picked:
    """A selected vertex of an object.

    Attributes
    ----------
    index : int
    is_active : bool
        Whether it is the active vertex, the one selected last by a click.
    count : int
        Number of selected vertices.
    """

    index: int
    is_active: bool
    count: int

    def __str__(self) -> str:
        """Describe it in words, such as "vertex 12, the active one of 2 selected"."""
        if self.count == 1:
            return tr("vertex {index}").format(index=self.index)
        template = (
            tr("vertex {index}, the active one of {count:,} selected")
            if self.is_active
            else tr("vertex {index}, the first one of {count:,} selected")
        )
        return template.format(index=self.index, count=self.count)


def picked(item: Any) -> Picked | None:
    """Find the active vertex of an object, or else the selected one with the lowest index.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object; in object mode, the selection of edit mode is used.

    Returns
    -------
    picked : Picked or None
        None if no vertex is selected.
    """
    if item.mode == "EDIT":
        edited = bmesh.from_edit_mesh(item.data)
        active = _active(edited)
        index = _first(edited) if active is None else active
        return None if index is None else Picked(index, active is not None, item.data.total_vert_sel)
    import numpy as np

    selected = np.empty(len(item.data.vertices), bool)
    item.data.vertices.foreach_get("select", selected)
    if not selected.any():
        return None
    copy = bmesh.new()
    try:
        # It knows which vertex is active, but takes all corners of selected faces for selected.
        copy.from_mesh(item.data, face_normals=False, vertex_normals=False)
        active = _active(copy)
    finally:
        copy.free()
    if active is not None and selected[active]:
        return Picked(active, True, int(selected.sum()))
    return Picked(int(selected.argmax()), False, int(selected.sum()))


def picked_text(item: Any) -> str:
    """Describe which vertex heat will spread from, or how to choose one; cheap enough for a panel's draw.

    Parameters
    ----------
    item : bpy.types.Object or None

    Returns
    -------
    text : str
    """
    if item is None or item.type != "MESH" or item.mode != "EDIT":
        return tr("From the vertex selected in edit mode")
    count = item.data.total_vert_sel
    if not count:
        return tr("Select the vertex it spreads from")
    active = _active(bmesh.from_edit_mesh(item.data))
    if active is not None:
        return tr("From {vertex}").format(vertex=Picked(active, True, count))
    # Which one is first takes a look at every vertex, too long for a panel.
    return counted("From the selected vertex", "From the first of {count:,} selected vertices", count)


def _active(mesh: Any) -> int | None:
    active = mesh.select_history.active
    return int(active.index) if isinstance(active, bmesh.types.BMVert) and active.select else None


def _first(mesh: Any) -> int | None:
    return next((vertex.index for vertex in mesh.verts if vertex.select), None)
