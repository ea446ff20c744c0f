# SPDX-License-Identifier: MIT
"""Steps of Gauss and Newton's method on distances along normals, over similarity transformations."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.alignment import Frame

__all__ = ["height_derivatives", "step_of"]


def height_derivatives(arms: FloatArray, normals: FloatArray) -> FloatArray:
    """Differentiate the heights of points along normals by how the points are moved.

    Parameters
    ----------
    arms : (n, 3) array
        From the centre of turning and growing to the points.
    normals : (n, 3) array

    Returns
    -------
    columns : (n, 7) array
        By turning about three axes, moving along them, growing.
    """
    return np.concatenate(
        [np.cross(arms, normals), normals, (arms * normals).sum(axis=1, keepdims=True)], axis=1
    )


def step_of(frame: Frame, middle: FloatArray, solution: FloatArray, least: float, largest: float) -> Frame:
    """Take a step from a frame.

    Parameters
    ----------
    frame : Frame
    middle : (3,) array
        Centre of turning and growing.
    solution : (7,) array
        In the order of `height_derivatives`.
    least, largest : float
        Bounds of the growth in one step.

    Returns
    -------
    frame : Frame
    """
    turn = Rotation.from_rotvec(solution[:3]).as_matrix()
    growth = float(np.clip(1 + solution[6], least, largest))
    rotation = turn @ frame.rotation
    translation = growth * turn @ (frame.translation - middle) + middle + solution[3:6]
    return Frame(growth * frame.scale, rotation, translation)
