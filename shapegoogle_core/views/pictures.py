# SPDX-License-Identifier: MIT
"""Pictures of normals and depth from several directions, drawn from points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["normal_pictures"]

FloatArray = NDArray[np.float64]
Pictures = NDArray[np.float32]

_LEVELS = 65_535


def normal_pictures(points: FloatArray, normals: FloatArray, rotations: FloatArray, size: int) -> Pictures:
    """Draw points from several directions, without perspective; the nearest point of each pixel is seen.

    Parameters
    ----------
    points, normals : (n, 3) array
        Inside the ball of radius 1, see `surface_points`.
    rotations : (V, 3, 3) array
        Rows point right, up and towards the viewer.
    size : int
        Width and height in pixels.

    Returns
    -------
    pictures : (V, size, size, 4) array of float32
        The normal in the axes of the picture (right, up, towards the viewer, which is never negative), and
        the depth from 0 (far) to 1 (near). Zeros where nothing is seen.

    Examples
    --------
    >>> import trimesh
    >>> from shapegoogle_core.views import VIEW_ROTATIONS, normal_pictures, surface_points
    >>> points, normals = surface_points(trimesh.creation.icosphere(3), 30_000)
    >>> pictures = normal_pictures(points, normals, VIEW_ROTATIONS, 64)
    >>> pictures.shape, bool(pictures[0, 32, 32, 2] > 0.99)
    ((12, 64, 64, 4), True)
    """
    # The last row has the depth, from which points are ordered.
    positions, directions = (values.T.astype(np.float32) for values in (points, normals))
    drawn = np.zeros((len(rotations), size * size, 4), np.float32)
    for picture, rotation in zip(drawn, rotations.astype(np.float32), strict=True):
        x, y, z = rotation @ positions
        half = np.float32(size / 2)
        column = (x * half + half).astype(np.int32).clip(0, size - 1)
        row = (half - y * half).astype(np.int32).clip(0, size - 1)
        depth = np.clip(z * np.float32(0.5) + np.float32(0.5), 0, 1)
        # Sixteen bits are sorted in linear time; of what is assigned to a pixel, the last and nearest stays.
        order = (depth * _LEVELS).astype(np.uint16).argsort(kind="stable")
        nearest = np.full(size * size, -1, np.int32)
        nearest[(row * size + column)[order]] = order
        seen = np.flatnonzero(nearest >= 0)
        owner = nearest[seen]
        normal = rotation @ directions[:, owner]
        picture[seen, :3] = (normal * np.where(normal[2] < 0, -1, 1)).T
        picture[seen, 3] = depth[owner]
    return drawn.reshape(len(rotations), size, size, 4)
