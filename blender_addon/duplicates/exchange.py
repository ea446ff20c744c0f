# SPDX-License-Identifier: GPL-3.0-or-later
"""Exchange the mesh of one object so that nothing moves, check that nothing did, and take it back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ..scene.mesh_arrays import vertex_positions
from ..translation import tr
from .congruence import TOLERANCE

FloatArray = NDArray[np.float64]

__all__ = ["Exchange", "Kept", "exchange_of", "is_deformed", "moved_reason", "points_seen", "put_in_place"]

# Blender keeps matrices in single precision: places far from the origin are less exact.
SINGLE = 4 * 2.0**-23  # four times the step from 1 to the next float32
# Of these kinds a parent deforms its children, as a modifier would.
DEFORMING_PARENTS = {"ARMATURE", "LATTICE", "CURVE"}


@dataclass(frozen=True, eq=False)
class Exchange:
    """An object that is to get another mesh, and the place where it then has to be.

    Attributes
    ----------
    item : bpy.types.Object
    data : bpy.types.Mesh
        The new mesh.
    before, wanted : (4, 4) array
        World matrix with the present and with the new mesh.
    corners : (8, 4) array
        Corners of the box around the new mesh.
    allowed : float
        How far they may end from where they belong.
    stays : bool
        Whether both matrices are the same.
    """

    item: Any
    data: Any
    before: FloatArray
    wanted: FloatArray
    corners: FloatArray
    allowed: float
    stays: bool


class Kept:
    """State of an object and of its children before its mesh is exchanged."""

    def __init__(self, item: Any, children: Sequence[Any]) -> None:
        self._item, self._data, self._basis = item, item.data, item.matrix_basis.copy()
        self.children = [
            (child, child.matrix_parent_inverse.copy(), child.matrix_world.copy()) for child in children
        ]

    def put_back(self) -> None:
        """Restore it; the view layer has to be updated afterwards."""
        self._item.data = self._data
        self._item.matrix_basis = self._basis
        for child, inverse, _ in self.children:
            child.matrix_parent_inverse = inverse


def exchange_of(item: Any, data: Any, correction: FloatArray) -> Exchange:
    """Plan the exchange of an object's mesh; `correction` carries the new mesh onto the old one."""
    before = np.array(item.matrix_world, np.float64)
    wanted = before @ correction
    corners = np.array([[*corner, 1.0] for corner in _box(data)])
    reach = np.linalg.norm(np.ptp((corners @ wanted.T)[:, :3], axis=0))
    allowed = float(TOLERANCE * reach + SINGLE * np.abs(before[:3, 3]).max())
    stays = _farthest(corners, before, wanted) <= allowed
    return Exchange(item, data, before, wanted, corners, allowed, stays)


def put_in_place(exchange: Exchange, kept: Kept) -> None:
    """Give an object the matrix that its new mesh needs, and have its children stay."""
    exchange.item.matrix_world = Matrix(exchange.wanted.tolist())
    # A child follows its parent's matrix: undo the change of that in the child's own.
    back = np.linalg.inv(exchange.wanted) @ exchange.before
    for child, inverse, _ in kept.children:
        child.matrix_parent_inverse = Matrix((back @ np.array(inverse, np.float64)).tolist())


def moved_reason(context: Any, exchange: Exchange, kept: Kept, seen: FloatArray | None) -> str:
    """Why an object that has got another mesh must get its own back, or an empty text."""
    item, allowed = exchange.item, exchange.allowed
    if _farthest(exchange.corners, np.array(item.matrix_world, np.float64), exchange.wanted) > allowed:
        return tr(
            "its rotation and scale cannot hold the mesh in place; apply its or its parents' scale first"
        )
    if any(not np.allclose(child.matrix_world, was, atol=allowed) for child, _, was in kept.children):
        return tr("its children would move")
    if seen is not None and not _same_points(seen, points_seen(context, item), allowed):
        if item.modifiers:
            return tr("its modifiers would give another shape")
        return tr("its parent would give another shape")
    return ""


def is_deformed(item: Any) -> bool:
    """Whether an object may be seen otherwise than its mesh says."""
    return bool(item.modifiers) or (item.parent is not None and item.parent_type in DEFORMING_PARENTS)


def _box(data: Any) -> FloatArray:
    """(8, 3) corners of the box around a mesh, in its own space."""
    points = vertex_positions(data)
    low, high = points.min(axis=0), points.max(axis=0)
    choice = np.array([[index >> axis & 1 for axis in range(3)] for index in range(8)], bool)
    return np.asarray(np.where(choice, high, low), np.float64)


def _farthest(corners: FloatArray, one: FloatArray, two: FloatArray) -> float:
    return float(np.linalg.norm((corners @ (one - two).T)[:, :3], axis=1).max())


def points_seen(context: Any, item: Any) -> FloatArray:
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
