# SPDX-License-Identifier: MIT
"""Points of the medial axis: the inner skeleton of a surface, which swelling and noise hardly move."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["medial_radii"]

# Radii halve quickly; after so many steps they have settled.
_STEPS = 12
_SETTLED = 1e-3
# Points close by are a little in front of or behind the tangent plane by chance, which would make the ball
# tiny. A point that is seen from the centre within 40° of p is not taken for the other side.
_LEAST_CHORD = 2 * np.sin(np.radians(40) / 2)


def medial_radii(points: FloatArray, normals: FloatArray, cloud: FloatArray, largest: float) -> FloatArray:
    """Radii of the balls that touch a surface at some points and hold no other point of it.

    Shrinking balls (Ma, Bae, Choi 2012): a ball that touches at p, with its centre at p - r n, is made
    smaller until it no longer holds any point of the cloud. Of the two balls, on either side of the surface,
    the smaller one is taken: the normals of many meshes point to either side, and solids are mostly thinner
    than what lies between them.

    Parameters
    ----------
    points, normals : (k, 3) arrays
        Normals of unit length.
    cloud : (n, 3) array
        Points that cover the surface densely.
    largest : float
        Radius to start from, in the unit of the points: what is flat, or open, has this one.

    Returns
    -------
    radii : (k,) array
        Positive where the centre is at p - r n, negative where it is at p + |r| n.
    """
    tree = cKDTree(cloud)
    behind = _shrunk(points, normals, cloud, tree, largest)
    before = _shrunk(points, -normals, cloud, tree, largest)
    radii: FloatArray = np.where(behind <= before, behind, -before)
    return radii


def _shrunk(
    points: FloatArray, normals: FloatArray, cloud: FloatArray, tree: cKDTree, largest: float
) -> FloatArray:
    radii = np.full(len(points), largest)
    open_ = np.arange(len(points))
    for _ in range(_STEPS):
        centers = points[open_] - radii[open_, None] * normals[open_]
        distances, nearest = tree.query(centers)
        offsets = points[open_] - cloud[nearest]
        # The ball through p and the point found, tangent at p, has radius ‖p - q‖² / (2 n·(p - q)).
        depths = 2 * (offsets * normals[open_]).sum(axis=1)
        squares = (offsets**2).sum(axis=1)
        inside = (distances < radii[open_] * (1 - _SETTLED)) & (depths > 0)
        smaller = np.divide(squares, depths, out=np.full(len(open_), np.inf), where=inside)
        inside &= squares > (_LEAST_CHORD * smaller) ** 2
        open_ = open_[inside]
        radii[open_] = np.minimum(radii[open_], smaller[inside])
        if len(open_) == 0:
            break
    return radii
