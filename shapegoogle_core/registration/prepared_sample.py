# SPDX-License-Identifier: MIT
"""`PreparedSample`: a sample with the search trees and distances that aligning it with many others needs."""

from __future__ import annotations

from copy import copy
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shapegoogle_core.registration.aligning.nearest_field import NearestField
from shapegoogle_core.registration.heat.bent_part import BentPart
from shapegoogle_core.registration.medial_axis import AxisMeasures, measure_axis
from shapegoogle_core.registration.point_distances import point_distances
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["PART_SCALES", "SCALES", "SHARED_SCALES", "PreparedSample"]

# All samples have unit area. So a part is larger than in its whole, and whatever is not swollen of a swollen
# shape is smaller than in the original: the query is tried at several scales.
SCALES = (1.0, 0.85, 0.7)
"""Scales of the query that an alignment tries besides guessed ones."""

PART_SCALES = (1.0, 0.9, 0.8, 0.7, 0.6)
"""Scales for a query that may be a part of the candidate, down to a third of its area."""

SHARED_SCALES = (1.0, 0.85, 1.2, 0.7, 0.6)
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
        # Shared by the copies at other scales, whoever asks first.
        self._fields: dict[bool, NearestField] = {}
        self._known_cells: dict[int, NDArray[np.int32]] = {}
        self._known_enlarged: dict[float, tuple[NDArray[np.float32], NDArray[np.float32]]] = {}
        self._known_scales: dict[
            float, tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]
        ] = {}

    def at_other_scales(self, scales: tuple[float, ...]) -> Self:
        """Return the same sample to be tried at other scales, with everything that is known of it.

        Parameters
        ----------
        scales : tuple of float

        Returns
        -------
        prepared : PreparedSample
        """
        other = copy(self)
        other.scales = scales
        other.__dict__.pop("at_scales", None)
        return other

    @cached_property
    def bent(self) -> BentPart | None:
        """The sample as a part in another pose; None if nothing is cut off, or it has no local heat."""
        heat = self.sample.local_heat
        return BentPart(heat) if heat is not None and self.sample.is_cut else None

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree of the points."""
        return cKDTree(self.points)

    @cached_property
    def center_tree(self) -> cKDTree:
        """Search tree of the points of the medial axis."""
        return cKDTree(self.centers)

    def cells(self, count: int) -> NDArray[np.int32]:
        """Assign each point to the nearest of the first points.

        Parameters
        ----------
        count : int
            Number of these.

        Returns
        -------
        cells : (m + 1,) array of int32
            The last one is `count`: where `NearestField` finds nothing, there is no cell.
        """
        if count not in self._known_cells:
            _, nearest = cKDTree(self.points[:count]).query(self.points)
            self._known_cells[count] = np.append(nearest, count).astype(np.int32)
        return self._known_cells[count]

    @cached_property
    def axis(self) -> AxisMeasures:
        """Measures of the medial axis."""
        return measure_axis(self.sample)

    @property
    def field(self) -> NearestField:
        """The nearest of the points."""
        return self._field(of_surface=True)

    @cached_property
    def field_normals(self) -> NDArray[np.float32]:
        """(m + 1, 3) normals of the points of the field; that of the one far away is 0."""
        return np.concatenate([self.normals, np.zeros((1, 3))]).astype(np.float32)

    @property
    def center_field(self) -> NearestField:
        """The nearest of the points of the medial axis."""
        return self._field(of_surface=False)

    def _field(self, *, of_surface: bool) -> NearestField:
        if of_surface not in self._fields:
            self._fields[of_surface] = NearestField(self.points if of_surface else self.centers)
        return self._fields[of_surface]

    @cached_property
    def at_scales(self) -> tuple[tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]], ...]:
        """Keypoints at each scale: descriptors, distances between points, distances between ball centres."""
        return tuple(self.at_scale(scale) for scale in self.scales)

    def at_scale(self, scale: float) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Compute the keypoints at one scale, each scale once.

        Parameters
        ----------
        scale : float

        Returns
        -------
        descriptors, distances, center_distances : arrays of float32
            As in `at_scales`.
        """
        if scale not in self._known_scales:
            points, centers = self._distances
            self._known_scales[scale] = (
                self.sample.descriptors_at(scale, _QUERY_KEYPOINTS),
                np.float32(scale) * points,
                np.float32(scale) * centers,
            )
        return self._known_scales[scale]

    def enlarged(self, scale: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Describe all keypoints at another size, as those of a whole; each size once.

        Parameters
        ----------
        scale : float

        Returns
        -------
        descriptors : (k, d) array of float32
        half_squares : (k,) array of float32
            Half the squared length of each descriptor.
        """
        if scale not in self._known_enlarged:
            descriptors = self.sample.descriptors_at(scale)
            self._known_enlarged[scale] = descriptors, (descriptors**2).sum(axis=1) / 2
        return self._known_enlarged[scale]

    @cached_property
    def _distances(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        few = slice(_QUERY_KEYPOINTS)
        return point_distances(self.key_points[few]), point_distances(self.key_centers[few])
