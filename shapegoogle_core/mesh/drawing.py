# SPDX-License-Identifier: MIT
"""Random points of a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["draw_points"]


def draw_points(
    areas: FloatArray, count: int, random: np.random.Generator
) -> tuple[NDArray[np.int64], FloatArray]:
    """Draw uniformly distributed points.

    Parameters
    ----------
    areas : (m,) array
        Of the faces, or in proportion to them; their sum is positive.
    count : int
        Number of points.
    random : numpy.random.Generator

    Returns
    -------
    faces : (count,) array of int
        The face of each point: one point in each of `count` slices of equal area, to avoid clusters and gaps.
    corners : (count, 3) array
        Barycentric coordinates.
    """
    total = np.cumsum(areas)
    place = (np.arange(count) + random.random(count)) / count * total[-1]
    face = np.minimum(np.searchsorted(total, place, side="right"), len(areas) - 1)
    root, other = np.sqrt(random.random(count)), random.random(count)
    return face, np.stack([1 - root, root * (1 - other), root * other], axis=1)
