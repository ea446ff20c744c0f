# SPDX-License-Identifier: MIT
"""Views of a shape from which people recognise it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.mesh import Mesh, MeshLike, as_mesh, face_areas

__all__ = ["canonical_view", "look_from"]

FloatArray = NDArray[np.float64]

_AXES = np.eye(3)
# Direction to the front of a shape by its up axis: +z where y is up (glTF and most files), −y where z is up
# (Blender).
_FRONT_OF_UP = {1: np.array([0.0, 0.0, 1.0]), 2: np.array([0.0, -1.0, 0.0])}
_TURN, _RAISE = np.radians(28), np.radians(18)
# Largest cosine between a side view and the front.
_SIDEWAYS = 0.3
# A shape is clearly thinnest along an axis if its extent is below this share of the next larger one.
_THIN = 0.75
_LEAN_TO_Z = 1.2


def look_from(direction: ArrayLike, up: ArrayLike) -> FloatArray:
    """Return the view from a direction.

    Parameters
    ----------
    direction : (3,) array_like
        Direction from the shape towards the viewer.
    up : (3,) array_like
        Direction that points up in the picture, not parallel to `direction`.

    Returns
    -------
    view : (3, 3) array
        Rotation whose rows point right, up and towards the viewer.

    Raises
    ------
    ValueError
        If the directions are parallel.

    Examples
    --------
    >>> from shapegoogle_core.rendering import look_from
    >>> look_from([0, 0, 5], up=[0, 1, 0])
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    toward = np.asarray(direction, float)
    right = np.cross(np.asarray(up, float), toward)
    if np.linalg.norm(right) <= 1e-9 * np.linalg.norm(toward) * np.linalg.norm(up):
        raise ValueError("the view's direction and up must not be parallel")
    toward = toward / np.linalg.norm(toward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right), toward])


def canonical_view(mesh: MeshLike, up_axis: int | None = None) -> FloatArray:
    """Choose a three-quarter view that shows most of a shape, upright if the up axis can be guessed.

    Files have y or z up and rarely say which. An axis along which the shape is clearly thinnest is not up.
    Otherwise the axis with the wider base is up, and z if the bases are similar. The view shows the broadest
    side, turned and raised a little.

    Parameters
    ----------
    mesh : MeshLike
    up_axis : {1, 2}, optional
        Up axis where it is known: y (1), or z (2) as in Blender.

    Returns
    -------
    view : (3, 3) array
        As from `look_from`.

    Examples
    --------
    >>> import trimesh
    >>> from shapegoogle_core.rendering import canonical_view
    >>> view = canonical_view(trimesh.creation.box((0.4, 0.2, 1.8)))
    >>> bool(view[1, 2] > 0.9)  # z is up
    True
    """
    mesh = as_mesh(mesh)
    points, weights = _surface_samples(mesh)
    centred = points - np.average(points, axis=0, weights=weights)
    covariance = (centred * weights[:, None]).T @ centred / weights.sum()

    extents = np.ptp(mesh.vertices, axis=0)
    thin = int(extents.argmin())
    clearly_thin = extents[thin] < _THIN * np.sort(extents)[1]
    if up_axis is None:
        candidates = [axis for axis in (2, 1) if not (clearly_thin and axis == thin)]
        base_widths = {axis: _base_width(centred, axis) for axis in candidates}
        up_axis = max(candidates, key=lambda axis: base_widths[axis] * (_LEAN_TO_Z if axis == 2 else 1))
    up, front = _AXES[up_axis], _FRONT_OF_UP[up_axis]
    # Look along the direction in which the shape is thin seen from above.
    ground = np.stack([front, np.cross(up, front)])
    _, flat_directions = np.linalg.eigh(ground @ covariance @ ground.T)
    side = flat_directions[:, 0] @ ground
    toward_front = float(side @ front)
    # Prefer the front, and otherwise the right side, so that similar shapes face the same way.
    if toward_front < -_SIDEWAYS or (abs(toward_front) <= _SIDEWAYS and side @ np.cross(up, front) < 0):
        side = -side
    across = np.cross(up, side)
    turn = _TURN if across @ front >= 0 else -_TURN
    level = np.cos(turn) * side + np.sin(turn) * across
    return look_from(np.cos(_RAISE) * level + np.sin(_RAISE) * up, up)


def _surface_samples(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """Return points and weights that represent the surface, whatever the density of its vertices."""
    areas = face_areas(mesh)
    if areas.sum() > 0:
        return mesh.vertices[mesh.faces].mean(axis=1), areas
    return mesh.vertices, np.ones(len(mesh.vertices))


def _base_width(centred: FloatArray, axis: int) -> float:
    """Return the width of the lowest twentieth of a shape along an axis, relative to that of the whole."""
    heights = centred[:, axis]
    base = centred[heights <= heights.min() + 0.05 * np.ptp(heights)]
    others = [other for other in range(3) if other != axis]
    return float(
        np.prod(np.ptp(base[:, others], axis=0)) / max(np.prod(np.ptp(centred[:, others], axis=0)), 1e-300)
    )
