# SPDX-License-Identifier: MIT
"""The two poses in which a shape is drawn: straightened in its file's axes, and in its principal axes.

Files of one kind of thing are turned in all ways: glTF has y up, Blender z, scans anything. Most made things
have faces at right angles, and these give axes that depend on the shape alone, up to the 48 symmetries of a
cube. Round and grown things keep the axes of their file; their principal axes stand in for them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.views.directions import symmetries

__all__ = ["principal_axes", "straight_axes"]

FloatArray = NDArray[np.float64]
Vectors = NDArray[np.floating]

# Turns that improve all three pairs of axes; a few are enough from any start.
_SWEEPS = 6
# Gain of straightness for which the axes of the file are given up, see `straight_axes`. Of an even
# distribution of normals it is 0.6, of a box in its axes 1.
_GAIN = 0.05
_ROTATIONS = np.array(
    [symmetry.matrix for symmetry in symmetries() if np.linalg.det(symmetry.matrix) > 0], np.float64
)


def principal_axes(points: Vectors) -> FloatArray:
    """Find the directions in which points spread most, in the order of their spread.

    Parameters
    ----------
    points : (n, 3) array

    Returns
    -------
    axes : (3, 3) array
        Rows are orthonormal. Each points to the side where the points reach farther.
    """
    if len(points) == 0:
        return np.eye(3)
    centred = points - points.mean(axis=0)
    axes = _spread_axes(centred)
    along = axes @ centred.T
    lean = (along * along * along).sum(axis=1)
    return np.asarray(axes * np.where(lean < 0, -1, 1)[:, None])


def straight_axes(points: Vectors, normals: Vectors) -> FloatArray:
    """Find the axes along which most normals point, if they clearly do; otherwise keep those of the file.

    Maximises the straightness, the mean of n_x⁴ + n_y⁴ + n_z⁴ over all unit normals n. In the plane of two
    axes the best turn has a closed form, so the axes are turned pair by pair, from three starts: the file's
    axes, and the principal axes of points and of normals.

    Parameters
    ----------
    points, normals : (n, 3) array
        From `surface_points`.

    Returns
    -------
    axes : (3, 3) array
        Rows are orthonormal and right-handed. Of the 24 ways to name and direct them, the one nearest to the
        axes of the file.
    """
    if len(points) == 0:
        return np.eye(3)
    moments = _fourth_moments(normals)
    starts = (np.eye(3), _spread_axes(points - points.mean(axis=0)), _spread_axes(normals))
    found = [_straightened(moments, start) for start in starts]
    best = max(found, key=lambda axes: _straightness(moments, axes))
    if _straightness(moments, best) - _straightness(moments, np.eye(3)) < _GAIN:
        return np.eye(3)
    if np.linalg.det(best) < 0:
        best = -best
    named = _ROTATIONS @ best
    return np.asarray(named[np.trace(named, axis1=1, axis2=2).argmax()])


def _spread_axes(vectors: Vectors) -> FloatArray:
    """Eigenvectors of the second moments as rows, the largest first."""
    return np.asarray(np.linalg.eigh(vectors.T @ vectors)[1][:, ::-1].T)


def _fourth_moments(normals: Vectors) -> FloatArray:
    """Compute the mean of all products of four components, as a matrix (6, 6) of pairs; see `_pair`."""
    x, y, z = normals.T
    pairs = np.stack([x * x, y * y, z * z, x * y, x * z, y * z])
    return np.asarray(pairs @ pairs.T / len(normals), np.float64)


def _pair(first: FloatArray, second: FloatArray) -> FloatArray:
    """Write the product of a normal's parts along two axes as a sum of the products of its components."""
    (a, b, c), (d, e, f) = first, second
    return np.array([a * d, b * e, c * f, a * e + b * d, a * f + c * d, b * f + c * e])


def _straightness(moments: FloatArray, axes: FloatArray) -> float:
    return float(sum(_pair(axis, axis) @ moments @ _pair(axis, axis) for axis in axes))


def _straightened(moments: FloatArray, start: FloatArray) -> FloatArray:
    axes = start.copy()
    for _ in range(_SWEEPS):
        for first, second in _PAIRS:
            xx, yy, xy = (
                _pair(axes[i], axes[j]) for i, j in ((first, first), (second, second), (first, second))
            )
            # In the plane the sum of fourth powers is a constant plus a cos 4t + b sin 4t.
            a = (xx @ moments @ xx + yy @ moments @ yy - 6 * (xx @ moments @ yy)) / 4
            b = xy @ moments @ (xx - yy)
            angle = np.arctan2(b, a) / 4
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            axes[[first, second]] = turn @ axes[[first, second]]
    return axes


_PAIRS: Sequence[tuple[int, int]] = ((0, 1), (0, 2), (1, 2))
