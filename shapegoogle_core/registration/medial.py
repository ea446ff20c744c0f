# SPDX-License-Identifier: MIT
"""Points of the medial axis: the inner skeleton of a surface, which swelling and noise hardly move."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["ball_centers", "medial_radii"]

# Radii shrink quickly and converge within this number of steps.
_STEPS = 12
_CONVERGED = 1e-3
# Points in a leaf of the search tree. Many points are about equally far from a point of the medial axis, for
# which most of a fine tree would be visited.
_LEAF = 64
# Because of noise, points near p lie a little in front of or behind its tangent plane and would make the ball
# tiny. A point that is seen from the centre within 40° of p does not count as the other side.
_SMALLEST_CHORD = 2 * np.sin(np.radians(40) / 2)


def medial_radii(points: FloatArray, normals: FloatArray, cloud: FloatArray, largest: float) -> FloatArray:
    """Compute the radii of the balls that touch a surface at given points and hold no other point of it.

    Shrinking balls (Ma, Bae and Choi 2012): a ball that touches the surface at p, with its centre at p - r n,
    shrinks until it no longer holds any point of the cloud. The smaller one of the two balls, one on either
    side of the surface, is used: the normals of many meshes are not oriented, and solids are mostly thinner
    than the gaps between them.

    Parameters
    ----------
    points, normals : (k, 3) arrays
        The normals have unit length.
    cloud : (n, 3) array
        Points that cover the surface densely.
    largest : float
        Initial radius, in the unit of the points, which is kept where the surface is flat or open.

    Returns
    -------
    radii : (k,) array
        Positive where the centre is at p - r n, negative where it is at p + |r| n.
    """
    tree = cKDTree(cloud, leafsize=_LEAF)
    behind = _shrunk(points, normals, cloud, tree, largest)
    before = _shrunk(points, -normals, cloud, tree, largest)
    return np.where(behind <= before, behind, -before)


def ball_centers(points: FloatArray, normals: FloatArray, radii: FloatArray) -> FloatArray:
    """Compute the centres of medial balls, which are points of the medial axis.

    Parameters
    ----------
    points, normals : (..., 3) arrays
    radii : (...) array
        From `medial_radii`.

    Returns
    -------
    centers : (..., 3) array
    """
    return np.asarray(points - radii[..., None] * normals)


def _shrunk(
    points: FloatArray, normals: FloatArray, cloud: FloatArray, tree: cKDTree, largest: float
) -> FloatArray:
    radii = np.full(len(points), largest)
    shrinking = np.arange(len(points))
    for _ in range(_STEPS):
        centers = points[shrinking] - radii[shrinking, None] * normals[shrinking]
        distances, nearest = tree.query(centers)
        offsets = points[shrinking] - cloud[nearest]
        # The ball through p and the point found, tangent at p, has radius ‖p - q‖² / (2 n·(p - q)).
        depths = 2 * (offsets * normals[shrinking]).sum(axis=1)
        squares = (offsets**2).sum(axis=1)
        inside = (distances < radii[shrinking] * (1 - _CONVERGED)) & (depths > 0)
        smaller = np.divide(squares, depths, out=np.full(len(shrinking), np.inf), where=inside)
        inside &= squares > (_SMALLEST_CHORD * smaller) ** 2
        shrinking = shrinking[inside]
        radii[shrinking] = np.minimum(radii[shrinking], smaller[inside])
        if len(shrinking) == 0:
            break
    return radii
