# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender objects ↔ core meshes: the only place that reads or writes the meshes of bpy."""

from .objects import (
    base_mesh,
    evaluated_mesh,
    joined_name,
    mesh_objects,
    new_object,
    query_meshes,
    selected_part,
    shape_objects,
    split_evaluated,
)

__all__ = [
    "base_mesh",
    "evaluated_mesh",
    "joined_name",
    "mesh_objects",
    "new_object",
    "query_meshes",
    "selected_part",
    "shape_objects",
    "split_evaluated",
]
