# SPDX-License-Identifier: MIT
"""Similarity transformations x ↦ s R x + t between the units of two samples, and their least-squares fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Frame", "similarity_transformations"]


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
    first, second = first - first_mean[:, None], second - second_mean[:, None]
    covariances = (weights[..., None] * second).transpose(0, 2, 1) @ first
    left, values, right = np.linalg.svd(covariances)
    sign = np.sign(np.linalg.det(left) * np.linalg.det(right))
    left[:, :, 2] *= sign[:, None]
    values[:, 2] *= sign
    rotations = left @ right
    spread = (weights * (first**2).sum(axis=2)).sum(axis=1)
    scales = values.sum(axis=1) / np.maximum(spread, np.finfo(float).tiny)
    translations = second_mean - scales[:, None] * (rotations @ first_mean[..., None])[..., 0]
    return scales, rotations, translations
