# SPDX-License-Identifier: MIT
"""Distances between bags."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["row_distances"]


def row_distances(metric: str, first: FloatBags, second: FloatBags) -> FloatArray:
    """Compute the distances between the rows of two arrays.

    Parameters
    ----------
    metric : {"cosine", "l1"}
    first, second : (n, p) arrays
        From `ShapeModel.comparable`. Either may have a single row.

    Returns
    -------
    distances : (n,) array
        At least 0.
    """
    if metric == "l1":
        return np.asarray(np.abs(first - second).sum(axis=1, dtype=np.float64))
    return np.asarray(np.clip(1 - (first * second).sum(axis=1, dtype=np.float64), 0, 2))
