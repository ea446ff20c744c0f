# SPDX-License-Identifier: MIT
"""Gauss-Newton steps on distances along normals, over similarity transformations."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.frames import Frame

__all__ = ["height_derivatives", "stepped"]


def height_derivatives(arms: FloatArray, normals: FloatArray) -> FloatArray:
    """Differentiate the heights of points along normals with respect to a similarity transformation.

    Parameters
    ----------
    arms : (n, 3) array
        Vectors from the centre of rotation and scaling to the points.
    normals : (n, 3) array

    Returns
    -------
    columns : (n, 7) array
        Derivatives by rotation about three axes, translation along them, and scaling.
    """
    return np.concatenate(
        [np.cross(arms, normals), normals, (arms * normals).sum(axis=1, keepdims=True)], axis=1
    )


def stepped(frame: Frame, middle: FloatArray, solution: FloatArray, smallest: float, largest: float) -> Frame:
    """Apply a Gauss-Newton step to a frame.

    Parameters
    ----------
    frame : Frame
    middle : (3,) array
        Centre of rotation and scaling.
    solution : (7,) array
        In the order of `height_derivatives`.
    smallest, largest : float
        Bounds of the factor by which one step may scale.

    Returns
    -------
    frame : Frame
    """
    turn = Rotation.from_rotvec(solution[:3]).as_matrix()
    growth = float(np.clip(1 + solution[6], smallest, largest))
    rotation = turn @ frame.rotation
    translation = growth * turn @ (frame.translation - middle) + middle + solution[3:6]
    return Frame(growth * frame.scale, rotation, translation)
