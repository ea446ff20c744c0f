# SPDX-License-Identifier: GPL-3.0-or-later
"""Give objects another mesh. Their transforms, modifiers, parents, children and old meshes are kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ..translation import tr
from .incoming import Incoming

FloatArray = NDArray[np.float64]

__all__ = ["Choices", "Swapped", "by_mesh", "reason_against", "swap", "upright"]

# A matrix that moves no corner of a mesh farther, in units of its extent, is none.
_SAME = 1e-5


@dataclass(frozen=True)
class Choices:
    """What is asked of a replacement.

    Attributes
    ----------
    align : bool
        Turn, move and scale the new mesh to where the old one was.
    keep_materials : bool
        Keep the object's materials instead of those of the new mesh.
    keep_modifiers : bool
        Leave the object's modifiers on; they act on the new mesh.
    keep_mesh : bool
        Keep old meshes that no object shows any more.
    """

    align: bool = True
    keep_materials: bool = False
    keep_modifiers: bool = False
    keep_mesh: bool = True


@dataclass
class Swapped:
    """Result of a replacement.

    Attributes
    ----------
    items : list of bpy.types.Object
        Those that have the new mesh.
    aligned : int
        How many of them have it where the old one was.
    kept_meshes : list of str
        Old meshes that are kept for nothing else.
    switched_off : list of str
        Objects whose modifiers are off now.
    """

    items: list[Any] = field(default_factory=list)
    aligned: int = 0
    kept_meshes: list[str] = field(default_factory=list)
    switched_off: list[str] = field(default_factory=list)


def reason_against(item: Any, mesh_uid: int = 0) -> str:
    """Why an object must not get another mesh, or an empty text.

    Parameters
    ----------
    item : bpy.types.Object
    mesh_uid : int, optional
        Session number of the new mesh.
    """
    if item.type != "MESH":
        return tr("it is no mesh; convert it to one first")
    if item.library is not None or item.override_library is not None:
        return tr("it lies in another file; make it local first")
    if mesh_uid and item.data.session_uid == mesh_uid:
        return tr("it is the match, or shares its mesh")
    if any(child.parent_type.startswith("VERTEX") for child in item.children):
        return tr("children hang on its vertices")
    return ""


def by_mesh(items: Sequence[Any]) -> dict[Any, list[Any]]:
    """Group objects by their mesh.

    Parameters
    ----------
    items : sequence of bpy.types.Object

    Returns
    -------
    groups : dict of bpy.types.Mesh to list of bpy.types.Object
        In the order of the objects.
    """
    groups: dict[Any, list[Any]] = {}
    for item in items:
        groups.setdefault(item.data, []).append(item)
    return groups


def swap(
    groups: Sequence[Sequence[Any]],
    incoming: Incoming,
    data: Any,
    places: Sequence[FloatArray | None],
    choices: Choices,
) -> Swapped:
    """Give objects another mesh.

    Parameters
    ----------
    groups : sequence of sequence of bpy.types.Object
        Objects that share a mesh, as from `by_mesh`.
    incoming : Incoming
    data : bpy.types.Mesh
        Its mesh.
    places : sequence of (4, 4) array or None
        For each group, from the new mesh to the world at the place of its first object; None where the two
        shapes do not fit.
    choices : Choices

    Returns
    -------
    swapped : Swapped
    """
    done = Swapped()
    for items, place in zip(groups, places, strict=True):
        old = items[0].data
        correction, aligned = _correction(items[0], incoming, place, choices)
        new = _corrected(data, incoming, correction)
        is_shared = incoming.is_shared and new == data
        for item in items:
            exchanged = _exchange(item, new, is_shared, choices, done)
            # The others share the copy that the first one got.
            is_shared, new = is_shared and exchanged == new, exchanged
        done.items += items
        done.aligned += len(items) if aligned else 0
        if not old.users and choices.keep_mesh:
            old.use_fake_user = True
            done.kept_meshes.append(old.name)
    return done


def _correction(
    item: Any, incoming: Incoming, place: FloatArray | None, choices: Choices
) -> tuple[FloatArray, bool]:
    """Matrix that the new mesh gets, in the object's space; whether it is then where the old mesh was."""
    if not choices.align:
        return np.eye(4), False
    matrix = np.array(item.matrix_world, np.float64)
    if place is not None and abs(np.linalg.det(matrix[:3, :3])) > 0:
        return np.linalg.inv(matrix) @ place, True
    old = np.array([corner[:] for corner in item.bound_box], np.float64)
    return upright(np.array(incoming.matrix, np.float64), incoming.surface.vertices, old), False


def upright(matrix: FloatArray, vertices: FloatArray, old: FloatArray) -> FloatArray:
    """Choose how a shape of another form stands: as its mesh is, or as its object shows it.

    Objects that were imported often lie on their side, or are a hundred times too large, but for their
    matrix.

    Parameters
    ----------
    matrix : (4, 4) array
        Of the object of the new mesh.
    vertices : (n, 3) array
        Of the new mesh.
    old : (m, 3) array
        Points of the old mesh, or corners of its box.

    Returns
    -------
    chosen : (4, 4) array
        The identity, or the rotation and scale of the matrix; that with which the extents are more like those
        of the old mesh.
    """
    shown = np.eye(4)
    shown[:3, :3] = matrix[:3, :3]
    least = 1e-3 * max(float(np.ptp(old, axis=0).max()), np.finfo(float).tiny)
    sides = np.log(np.maximum(np.ptp(old, axis=0), least))

    def difference(candidate: FloatArray) -> float:
        extents = np.ptp(vertices @ candidate[:3, :3].T, axis=0)
        return float(np.abs(np.log(np.maximum(extents, least)) - sides).sum())

    return min((np.eye(4), shown), key=difference)


def _corrected(data: Any, incoming: Incoming, correction: FloatArray) -> Any:
    """Return the mesh itself where it fits as it is, or a copy that is turned, moved and scaled."""
    vertices = incoming.surface.vertices
    moved = vertices @ correction[:3, :3].T + correction[:3, 3]
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if np.abs(moved - vertices).max() <= _SAME * extent:
        return data
    new = data.copy()
    new.transform(Matrix(correction.tolist()), shape_keys=True)
    if np.linalg.det(correction[:3, :3]) < 0:
        new.flip_normals()
    new.update()
    return new


def _exchange(item: Any, new: Any, is_shared: bool, choices: Choices, done: Swapped) -> Any:
    """Give an object its new mesh; return it, which may be a copy."""
    materials = [slot.material for slot in item.material_slots]
    if choices.keep_materials and materials and not new.materials and (is_shared or new.library is not None):
        # It gets a slot, which those that have it already do not.
        new = new.copy()
    item.data = new
    for number, slot in enumerate(item.material_slots):
        if choices.keep_materials and materials:
            # At the object, so that others with this mesh are not changed.
            slot.link = "OBJECT"
            slot.material = materials[min(number, len(materials) - 1)]
        else:
            slot.link = "DATA"
    if choices.keep_materials and materials and not len(item.material_slots):
        new.materials.append(None)
        item.material_slots[0].link = "OBJECT"
        item.material_slots[0].material = materials[0]
    off = [modifier for modifier in item.modifiers if modifier.show_viewport or modifier.show_render]
    if off and not choices.keep_modifiers:
        for modifier in off:
            modifier.show_viewport = modifier.show_render = False
        done.switched_off.append(item.name)
    return new
