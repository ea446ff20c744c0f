# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of a match as it looks, brought into this file without anything else that its file has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy

from ..gallery import finding, placing
from ..gallery.errors import PlacingError
from ..gallery.labels import title
from ..scene.selection import mesh_objects

if TYPE_CHECKING:
    from shapegoogle_core import Mesh

__all__ = ["Incoming", "bring_mesh", "mesh_by_uid", "remove_unused"]

# What a mesh may need of a file beside itself.
_NEEDED = (bpy.types.Material, bpy.types.Image, bpy.types.Texture, bpy.types.NodeTree, bpy.types.Action)


@dataclass(frozen=True, eq=False)
class Incoming:
    """A mesh that is to take the place of others.

    Attributes
    ----------
    mesh_uid : int
        Session number of the mesh.
    name : str
        Of its object.
    is_shared : bool
        Whether an object of this file has it already, so that it must not be changed.
    matrix : mathutils.Matrix
        Of its object in its file, to the world.
    surface : Mesh
        Its vertices and triangles, in its own space.
    """

    mesh_uid: int
    name: str
    is_shared: bool
    matrix: Any
    surface: Mesh


def bring_mesh(context: Any, match: Any) -> Incoming:
    """Bring in the mesh of a match; the scene and the selection are as before.

    Parameters
    ----------
    context : bpy.types.Context
        In object mode.
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    incoming : Incoming
        With the mesh of its object itself, if that looks like it; otherwise as it looks with its modifiers.

    Raises
    ------
    PlacingError
        If the match has no single mesh, or is gone.
    """
    name = title(match)
    if match.shape_type in finding.WHOLES:
        raise PlacingError(
            "{name!r} consists of several objects, which no mesh can hold; append it instead", name=name
        )
    here = finding.object_of(context, match)
    if here is not None:
        return _incoming(context, here, here.name, is_new=False)
    layer = context.view_layer
    selected, active = list(layer.objects.selected), layer.objects.active
    before = set(bpy.data.user_map())
    found: Incoming | None = None
    try:
        objects = placing.bring_in(context, match.source, finding.sought(match))
        is_blend = match.source.lower().endswith(".blend")
        item = objects[0] if is_blend else _joined(context, mesh_objects(objects))
        layer.update()
        found = _incoming(context, item, name, is_new=True)
        return found
    finally:
        _remove_rest(context, before, 0 if found is None else found.mesh_uid)
        for item in layer.objects:
            item.select_set(item in selected)
        layer.objects.active = active


def mesh_by_uid(uid: int) -> Any | None:
    """Return a mesh of this file by its session number; None after an undo has removed it."""
    return next((data for data in bpy.data.meshes if data.session_uid == uid), None)


def _joined(context: Any, items: Sequence[Any]) -> Any | None:
    """Join the objects of a mesh file, which is one shape however Blender imports it."""
    if len(items) > 1:
        placing.select_only(context, items)
        bpy.ops.object.join()
    return items[0] if items else None


def _incoming(context: Any, item: Any | None, name: str, *, is_new: bool) -> Incoming:
    from shapegoogle_core import Mesh

    from ..scene.mesh_arrays import triangles, vertex_positions

    if item is None or item.type == "POINTCLOUD":
        raise PlacingError("{name!r} has no faces; a mesh cannot be replaced by points", name=name)
    looks_like_data = item.type == "MESH" and item.data.shape_keys is None and not _is_changed(item)
    if looks_like_data:
        data = item.data
    else:
        depsgraph = context.evaluated_depsgraph_get()
        try:
            data = bpy.data.meshes.new_from_object(
                item.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph
            )
        except RuntimeError as error:
            raise PlacingError(
                "{name!r} has no mesh that could take the place of another one; append it instead", name=name
            ) from error
        data.name = item.name
    vertices, faces = vertex_positions(data).astype("f8"), triangles(data)
    if not len(faces):
        raise PlacingError("{name!r} has no faces; a mesh cannot be replaced by points", name=name)
    if is_new and data.asset_data is not None:
        data.asset_clear()
    surface = Mesh(vertices, faces, name)
    return Incoming(data.session_uid, name, not is_new and looks_like_data, item.matrix_world.copy(), surface)


def _is_changed(item: Any) -> bool:
    """Whether an object looks otherwise than its mesh."""
    return any(modifier.show_viewport for modifier in item.modifiers) or (
        item.parent is not None and item.parent_type in {"ARMATURE", "LATTICE", "CURVE"}
    )


def _remove_rest(context: Any, before: set[Any], mesh_uid: int) -> None:
    """Remove all that came with a mesh and that it does not need."""
    new = [block for block in bpy.data.user_map() if block not in before]
    rest = [
        block
        for block in new
        if block.session_uid != mesh_uid and not isinstance(block, (*_NEEDED, bpy.types.Library))
    ]
    # Images and the like of what goes may go, too; those of the mesh have users.
    needed = {block.session_uid for block in new if isinstance(block, _NEEDED)}
    placing.remove(context, rest)
    remove_unused(needed)
    # Blender keeps the note of a file also where nothing is linked from it.
    blocks = list(bpy.data.user_map())
    used = {block.library for block in blocks}
    placing.remove(
        context,
        [
            block
            for block in blocks
            if isinstance(block, bpy.types.Library) and block not in before and block not in used
        ],
    )


def remove_unused(uids: set[int]) -> None:
    """Remove those of some data-blocks that nothing uses.

    Parameters
    ----------
    uids : set of int
        Session numbers.
    """
    while True:
        unused = [block for block in bpy.data.user_map() if block.session_uid in uids and not block.users]
        if not unused:
            return
        bpy.data.batch_remove(unused)
