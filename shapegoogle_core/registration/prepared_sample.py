# SPDX-License-Identifier: MIT
"""`PreparedSample`: a sample with the search trees and distances that aligning it with many others needs."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["PART_SCALES", "SCALES", "SHARED_SCALES", "PreparedSample", "point_distances"]

# All samples have unit area. So a part is larger than in its whole, and whatever is not swollen of a swollen
# shape is smaller than in the original: the query is tried at several scales.
SCALES = (1.0, 0.85, 1.2, 0.7)
"""Scales of the query that an alignment tries."""

PART_SCALES = (1.0, 0.85, 0.7, 0.6)
"""Scales for a query that may be a part of the candidate, down to a third of its area."""

SHARED_SCALES = (*SCALES, 0.6)
"""Scales for a search for shapes that share parts with the query."""

# Only this many of the query's keypoints are paired with the candidate's.
_QUERY_KEYPOINTS = 128


class PreparedSample:
    """A sample with the search trees and distances that its alignment with many others needs.

    Parameters
    ----------
    sample : SurfaceSample
    scales : tuple of float, optional
        Scales at which it is tried as a query.
    """

    def __init__(self, sample: SurfaceSample, scales: tuple[float, ...] = SCALES) -> None:
        self.sample = sample
        self.scales = scales
        self.points = sample.points
        self.normals = sample.normals
        self.centers = sample.centers
        keypoints = len(sample.descriptors)
        self.key_points = sample.points[:keypoints].astype(np.float32)
        self.key_centers = self.centers[:keypoints].astype(np.float32)

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree of the points."""
        return cKDTree(self.points)

    @cached_property
    def center_tree(self) -> cKDTree:
        """Search tree of the points of the medial axis."""
        return cKDTree(self.centers)

    @cached_property
    def at_scales(self) -> tuple[tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]], ...]:
        """Keypoints at each scale: descriptors, distances between points, distances between ball centres."""
        few = slice(_QUERY_KEYPOINTS)
        points, centers = point_distances(self.key_points[few]), point_distances(self.key_centers[few])
        return tuple(
            (
                self.sample.descriptors_at(scale, _QUERY_KEYPOINTS),
                np.float32(scale) * points,
                np.float32(scale) * centers,
            )
            for scale in self.scales
        )

    @cached_property
    def half_squares(self) -> NDArray[np.float32]:
        """(k,) half the squared length of each descriptor."""
        return np.asarray((self.sample.descriptors**2).sum(axis=1) / 2)


def point_distances(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Compute the distances between all points of each set.

    Parameters
    ----------
    points : (..., n, 3) array of float32

    Returns
    -------
    distances : (..., n, n) array of float32
        By one matrix product: fast, and exact to the square root of the rounding error.
    """
    squares = (points**2).sum(axis=-1)
    squared = squares[..., :, None] + squares[..., None, :] - 2 * points @ points.swapaxes(-1, -2)
    return np.asarray(np.sqrt(np.maximum(squared, 0, out=squared), out=squared))
