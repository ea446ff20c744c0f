# SPDX-License-Identifier: MIT
"""Similarity transformations x ↦ s R x + t between the units of two samples, and the steps of fits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from shapegoogle_core.mesh.measures import cross_products, dots
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Frame", "height_derivatives", "similarity_frame", "similarity_transformations", "stepped"]


@dataclass(frozen=True, eq=False)
class Frame:
    """Similarity transformation x ↦ scale · rotation x + translation from one sample's units to another's.

    Attributes
    ----------
    scale : float
    rotation : (3, 3) array
        Its determinant is -1 for a reflection.
    translation : (3,) array
    """

    scale: float
    rotation: FloatArray
    translation: FloatArray

    def apply(self, points: FloatArray) -> FloatArray:
        """Transform points.

        Parameters
        ----------
        points : (n, 3) array

        Returns
        -------
        transformed : (n, 3) array
        """
        return np.asarray(self.scale * points @ self.rotation.T + self.translation)

    def apply_inverse(self, points: FloatArray) -> FloatArray:
        """Transform points back.

        Parameters
        ----------
        points : (n, 3) array

        Returns
        -------
        transformed : (n, 3) array
        """
        return np.asarray((points - self.translation) @ self.rotation / self.scale)

    def inverse(self) -> Frame:
        """Return the frame that undoes this one."""
        back = self.rotation.T
        return Frame(1 / self.scale, back, -(back @ self.translation) / self.scale)


def similarity_transformations(
    first: FloatArray, second: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Fit scales, rotations and translations to pairs of points in least squares (Umeyama 1991).

    Minimises Σ_i w_i ‖s R p_i + t - q_i‖² for each of b sets.

    Parameters
    ----------
    first, second : (b, n, 3) arrays
        p and q.
    weights : (b, n) array
        w ≥ 0, not all 0 in a set.

    Returns
    -------
    scales : (b,) array
    rotations : (b, 3, 3) array
        Proper rotations, never reflections.
    translations : (b, 3) array
    """
    weights = weights / weights.sum(axis=1, keepdims=True)
    first_mean = (weights[:, None] @ first)[:, 0]
    second_mean = (weights[:, None] @ second)[:, 0]
    centred = first - first_mean[:, None]
    weighted = weights[..., None] * centred
    # These sum to zero, so the other points need not be centred.
    covariances = second.transpose(0, 2, 1) @ weighted
    left, values, right = np.linalg.svd(covariances)
    sign = np.sign(np.linalg.det(left) * np.linalg.det(right))
    left[:, :, 2] *= sign[:, None]
    values[:, 2] *= sign
    rotations = left @ right
    spread = np.einsum("bni,bni->b", weighted, centred)
    scales = values.sum(axis=1) / np.maximum(spread, np.finfo(float).tiny)
    translations = second_mean - scales[:, None] * (rotations @ first_mean[..., None])[..., 0]
    return scales, rotations, translations


def similarity_frame(first: FloatArray, second: FloatArray, weights: FloatArray) -> Frame:
    """Fit one frame to pairs of points in least squares; see `similarity_transformations`.

    Parameters
    ----------
    first, second : (n, 3) arrays
    weights : (n,) array

    Returns
    -------
    frame : Frame
    """
    (scale,), (rotation,), (translation,) = similarity_transformations(
        first[None], second[None], weights[None]
    )
    return Frame(float(scale), rotation, translation)


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
    return np.concatenate([cross_products(arms, normals).T, normals, dots(arms, normals)[:, None]], axis=1)


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
