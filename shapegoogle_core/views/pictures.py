# SPDX-License-Identifier: MIT
"""Pictures of the normals of a shape from twelve directions, drawn from points and without holes.

Points take the same time for any shape, but leave holes where few of them fall on a large surface. A hole is
a pixel that lies much deeper than the surface around it, which a morphological closing of the depth finds
(Serra 1982); it takes over the nearest point of a neighbour.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.views.directions import DIRECTIONS, OPPOSITES, VIEW_ROTATIONS

__all__ = ["normal_pictures"]

Floats = NDArray[np.float32]
Owners = NDArray[np.int32]

# Depths are sorted in sixteen bits, which takes a linear time.
_LEVELS = np.float32(32_767)
# Rounding puts some points just outside the ball.
_INSIDE = np.float32(0.9999)
# Pixels around the picture, for the closing.
_BORDER = 2
# Deeper than any point.
_FAR = np.float32(-2)
# Pixels by which a hole lies deeper than what is around it.
_DEEPER = 3


def normal_pictures(points: NDArray[np.floating], normals: NDArray[np.floating], size: int) -> Floats:
    """Draw points from all directions, without perspective; the nearest point of each pixel is seen.

    Opposite directions share the order of the points by depth. Gaps of one or two pixels are closed.

    Parameters
    ----------
    points, normals : (n, 3) array
        Inside the ball of radius 1, see `surface_points`.
    size : int
        Width and height in pixels.

    Returns
    -------
    pictures : (12, size, size, 3) array of float32
        The normal in the axes of the picture (right, up, towards the viewer, which is never negative) from
        each of `VIEW_ROTATIONS`. Zeros where nothing is seen.

    References
    ----------
    J. Serra: Image Analysis and Mathematical Morphology. Academic Press, 1982.

    Examples
    --------
    >>> import trimesh
    >>> from shapegoogle_core.views import normal_pictures, surface_points
    >>> points, normals = surface_points(trimesh.creation.icosphere(3), 30_000)
    >>> pictures = normal_pictures(points, normals, 128)
    >>> pictures.shape, bool(pictures[0, 64, 64, 2] > 0.99)
    ((12, 128, 128, 3), True)
    """
    positions, directions = (np.ascontiguousarray(values.T, np.float32) for values in (points, normals))
    pictures = np.zeros((DIRECTIONS, size * size, 3), np.float32)
    if positions.shape[1] == 0:
        return pictures.reshape(DIRECTIONS, size, size, 3)
    for front, back in OPPOSITES:
        rotation = VIEW_ROTATIONS[front].astype(np.float32)
        depth, owners = _nearest(rotation @ positions, size)
        _close(depth, owners, np.float32(2 * _DEEPER / size))
        inner = owners[:, _BORDER:-_BORDER, _BORDER:-_BORDER]
        for picture, owner in ((front, inner[0]), (back, inner[1, :, ::-1])):
            frame = VIEW_ROTATIONS[picture].astype(np.float32)
            seen = np.flatnonzero(owner >= 0)
            normal = frame @ directions[:, owner.ravel()[seen]]
            normal *= np.where(normal[2] < 0, np.float32(-1), np.float32(1))
            pictures[picture, seen] = normal.T
    return pictures.reshape(DIRECTIONS, size, size, 3)


def _nearest(positions: Floats, size: int) -> tuple[Floats, Owners]:
    """Find the point that is seen at each pixel, from the front and from the back.

    Parameters
    ----------
    positions : (3, n) array
        To the right, up and towards the viewer in front.
    size : int

    Returns
    -------
    depth : (2, size + 4, size + 4) array
        Towards either viewer, in pixels of the viewer in front.
    owners : (2, size + 4, size + 4) array of int32
        −1 where nothing is seen.
    """
    width = size + 2 * _BORDER
    x, y, z = positions
    half = np.float32(size / 2)
    column = (x * (half * _INSIDE) + (half + _BORDER)).astype(np.int32)
    row = ((half + _BORDER) - y * (half * _INSIDE)).astype(np.int32)
    row *= width
    row += column
    # Of what is assigned to a pixel, the last and nearest stays.
    order = (z * (_LEVELS * _INSIDE) + _LEVELS).astype(np.uint16).argsort(kind="stable")
    pixels = row[order]
    owners = np.full((2, width * width), -1, np.int32)
    owners[0, pixels] = order
    owners[1, pixels[::-1]] = order[::-1]
    depth = z[owners]
    depth[1] *= -1
    depth[owners < 0] = _FAR
    return depth.reshape(2, width, width), owners.reshape(2, width, width)


def _close(depth: Floats, owners: Owners, deeper: np.float32) -> None:
    """Fill holes in place, by the owners of those neighbours that lie at the depth of the closed picture."""
    grown = np.maximum(np.maximum(depth[:, :-2], depth[:, 1:-1]), depth[:, 2:])
    grown = np.maximum(np.maximum(grown[:, :, :-2], grown[:, :, 1:-1]), grown[:, :, 2:])
    shrunk = np.minimum(np.minimum(grown[:, :-2], grown[:, 1:-1]), grown[:, 2:])
    closed = np.minimum(np.minimum(shrunk[:, :, :-2], shrunk[:, :, 1:-1]), shrunk[:, :, 2:])
    inner = (slice(None), slice(_BORDER, -_BORDER), slice(_BORDER, -_BORDER))
    side, row, column = np.nonzero(closed > depth[inner] + deeper)
    aim = closed[side, row, column]
    width = depth.shape[1]
    hole = (side * width + row + _BORDER) * width + column + _BORDER
    flat_depth, flat_owners = depth.reshape(-1), owners.reshape(-1)
    around = np.array([x + width * y for y in (-1, 0, 1) for x in (-1, 0, 1) if x or y])
    near = hole[:, None] + around
    chosen = np.abs(flat_depth[near] - aim[:, None]).argmin(axis=1)
    flat_owners[hole] = flat_owners[near[np.arange(len(hole)), chosen]]
