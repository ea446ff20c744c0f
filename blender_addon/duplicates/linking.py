# SPDX-License-Identifier: GPL-3.0-or-later
"""Let objects share one mesh so that nothing moves; objects where that is not certain are refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..scene.mesh_arrays import vertex_positions
from ..scene.selection import split_evaluated
from .congruence import TOLERANCE, congruence
from .mesh_data import WorldMesh, differing_data, world_mesh

FloatArray = NDArray[np.float64]

__all__ = ["Linked", "link_data"]

# Blender keeps matrices in single precision: places far from the origin are less exact.
SINGLE = 4 * 2.0**-23  # four times the step from 1 to the next float32
HIDDEN = "it is disabled in viewports or in an excluded collection, so its place is not known; show it first"
# Of these kinds a parent deforms its children, as a modifier would.
DEFORMING_PARENTS = {"ARMATURE", "LATTICE", "CURVE"}


@dataclass(frozen=True)
class Linked:
    """Result of linking.

    Attributes
    ----------
    linked : list of str
        Objects that use the first one's mesh now.
    refused : list of (str, str)
        Objects that were left as they are, and why.
    """

    linked: list[str]
    refused: list[tuple[str, str]]


def link_data(context: Any, objects: Sequence[Any]) -> Linked:
    """Give objects the mesh of the first one, their matrices corrected so that nothing moves.

    The meshes are compared again: they may have changed since the duplicates were found. Modifiers,
    materials of objects and children stay where they are.

    Parameters
    ----------
    context : bpy.types.Context
    objects : sequence of bpy.types.Object
        The first one is left as it is.

    Returns
    -------
    linked : Linked
    """
    first, others = objects[0], objects[1:]
    result = Linked([], [])
    others = [item for item in others if item.data != first.data]
    # The matrices of those that Blender does not evaluate are not to be trusted, nor checked afterwards.
    hidden = set(split_evaluated(objects, context)[1])
    reason = _mesh_reason(first.data) or ("it is being edited" if first.mode != "OBJECT" else "")
    reason = HIDDEN if first in hidden else reason
    target = None if reason else world_mesh(first)
    if target is None:
        reason = reason or "it has no extent"
        result.refused.extend((item.name, f"of {first.name!r}: {reason}") for item in others)
        return result
    corrections: dict[Any, tuple[FloatArray, bool] | str] = {}
    for item in others:
        reason = HIDDEN if item in hidden else _object_reason(item) or _mesh_reason(item.data)
        if not reason:
            data = item.data
            if data not in corrections:
                corrections[data] = _correction(target, world_mesh(item))
            correction = corrections[data]
            reason = (
                correction if isinstance(correction, str) else _link(context, item, first.data, *correction)
            )
        if reason:
            result.refused.append((item.name, reason))
        else:
            result.linked.append(item.name)
    return result


def _mesh_reason(data: Any) -> str:
    """Why a mesh must not be exchanged, or an empty text."""
    if data.library is not None or data.override_library is not None:
        return "its mesh lies in another file"
    if data.shape_keys is not None:
        return "its mesh has shape keys"
    if _is_animated(data):
        return "its mesh is animated"
    return ""


def _object_reason(item: Any) -> str:
    """Why an object must not get another mesh, or an empty text."""
    if item.library is not None or item.override_library is not None:
        return "it lies in another file"
    if item.mode != "OBJECT":
        return "it is being edited"
    if item.vertex_groups and (item.parent_type == "ARMATURE" or item.find_armature() is not None):
        return "an armature deforms it by its vertex groups"
    return ""


def _is_animated(block: Any) -> bool:
    animation = block.animation_data
    return animation is not None and bool(
        animation.action or len(animation.drivers) or len(animation.nla_tracks)
    )


def _correction(target: WorldMesh, own: WorldMesh | None) -> tuple[FloatArray, bool] | str:
    """Matrix from the target's mesh to an object's own, and whether the vertices are in the same order."""
    found = None if own is None else congruence(target.polygons, own.polygons)
    if found is None or own is None:
        return "its geometry is not the same any more; find duplicates again"
    differences = differing_data(target, own, found)
    if differences:
        return f"it has other {', '.join(differences)}"
    matrix = np.linalg.inv(own.matrix) @ found.matrix @ target.matrix
    return matrix, found.same_order


def _link(context: Any, item: Any, data: Any, correction: FloatArray, same_order: bool) -> str:
    """Exchange the mesh of one object; on any reason not to, everything is as before."""
    before = np.array(item.matrix_world, np.float64)
    wanted = before @ correction
    corners = np.array([[*corner, 1.0] for corner in _box(data)])
    reach = np.linalg.norm(np.ptp((corners @ wanted.T)[:, :3], axis=0))
    allowed = TOLERANCE * reach + SINGLE * np.abs(before[:3, 3]).max()
    stays = _farthest(corners, before, wanted) <= allowed
    reason = _moving_reason(context, item, stays, same_order)
    if reason:
        return reason
    seen = _evaluated(context, item) if _is_deformed(item) else None
    children = [
        (child, child.matrix_parent_inverse.copy(), child.matrix_world.copy()) for child in item.children
    ]
    old_data, old_basis = item.data, item.matrix_basis.copy()
    item.data = data
    if not stays:
        _place(item, children, before, wanted)
    context.view_layer.update()
    if _farthest(corners, np.array(item.matrix_world, np.float64), wanted) > allowed:
        reason = "its rotation and scale cannot hold the mesh in place; apply its or its parents' scale first"
    elif any(not np.allclose(child.matrix_world, was, atol=allowed) for child, _, was in children):
        reason = "its children would move"
    elif seen is not None and not _same_points(seen, _evaluated(context, item), allowed):
        reason = f"its {'modifiers' if item.modifiers else 'parent'} would give another shape"
    if reason:
        item.data = old_data
        item.matrix_basis = old_basis
        for child, inverse, _ in children:
            child.matrix_parent_inverse = inverse
        context.view_layer.update()
    return reason


def _place(
    item: Any, children: Sequence[tuple[Any, Any, Any]], before: FloatArray, wanted: FloatArray
) -> None:
    from mathutils import Matrix

    item.matrix_world = Matrix(wanted.tolist())
    # A child follows its parent's matrix: undo the change of that in the child's own.
    back = np.linalg.inv(wanted) @ before
    for child, inverse, _ in children:
        child.matrix_parent_inverse = Matrix((back @ np.array(inverse, np.float64)).tolist())


def _is_deformed(item: Any) -> bool:
    """Whether an object may be seen otherwise than its mesh says."""
    return bool(item.modifiers) or (item.parent is not None and item.parent_type in DEFORMING_PARENTS)


def _moving_reason(context: Any, item: Any, stays: bool, same_order: bool) -> str:
    """Why an object must not get a mesh with another origin or order of vertices, or an empty text."""
    if not same_order:
        if any(child.parent_type.startswith("VERTEX") for child in item.children):
            return "children hang on its vertices, which are in another order"
        if item.modifiers:
            return "it has modifiers, and its vertices are in another order"
    if stays:
        return ""
    if item.modifiers:
        return "it has modifiers, and its mesh is placed otherwise in its object"
    if _is_deformed(item):
        return "its parent deforms it, and its mesh is placed otherwise in its object"
    if _is_animated(item) or item.constraints:
        return "it is animated or constrained, and its mesh is placed otherwise in its object"
    if item.rigid_body is not None:
        return "it is a rigid body, and its mesh is placed otherwise in its object"
    if any(child.library is not None or child.override_library is not None for child in item.children):
        return "it has children from another file"
    if split_evaluated(item.children, context)[1]:
        return "it has children that are disabled in viewports or in excluded collections; show them first"
    users = bpy.data.user_map(subset=[item])[item]
    hangers = [
        user.name
        for user in users
        if isinstance(user, bpy.types.Object) and user.parent != item and user != item
    ]
    if hangers:
        return f"{hangers[0]!r} refers to it, and its mesh is placed otherwise in its object"
    return ""


def _box(data: Any) -> FloatArray:
    """(8, 3) corners of the box around a mesh, in its own space."""
    points = vertex_positions(data)
    low, high = points.min(axis=0), points.max(axis=0)
    choice = np.array([[index >> axis & 1 for axis in range(3)] for index in range(8)], bool)
    return np.asarray(np.where(choice, high, low), np.float64)


def _farthest(corners: FloatArray, one: FloatArray, two: FloatArray) -> float:
    return float(np.linalg.norm((corners @ (one - two).T)[:, :3], axis=1).max())


def _evaluated(context: Any, item: Any) -> FloatArray:
    """(n, 3) vertices as seen, in the world."""
    evaluated = item.evaluated_get(context.evaluated_depsgraph_get())
    data = evaluated.to_mesh()
    try:
        points = vertex_positions(data)
    finally:
        evaluated.to_mesh_clear()
    matrix: FloatArray = np.array(evaluated.matrix_world, np.float64)
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3], np.float64)


def _same_points(one: FloatArray, two: FloatArray, allowed: float) -> bool:
    return one.shape == two.shape and bool(np.abs(one - two).max(initial=0) <= 2 * allowed)
