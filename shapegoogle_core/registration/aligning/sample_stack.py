# SPDX-License-Identifier: MIT
"""`SampleStack`: samples of many candidates as stacked arrays, to compute with all of them at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.registration.medial_axis import AxisMeasures, axis_lengths, measure_axis
from shapegoogle_core.registration.point_distances import point_distances
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["SampleStack", "alike"]


@dataclass(frozen=True, eq=False)
class SampleStack:
    """Samples with the same numbers of points and keypoints.

    Attributes
    ----------
    points, normals, centers : (b, m, 3) arrays of float32
    lengths : (b, m) array of float32
        Length of the axis that each centre stands for, as a multiple of their mean; see `medial_axis`.
    descriptors : (b, k, d) array of float32
    half_squares : (b, k) array of float32
        Half the squared length of each descriptor.
    samples : tuple of SurfaceSample
    """

    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    centers: NDArray[np.float32]
    lengths: NDArray[np.float32]
    descriptors: NDArray[np.float32]
    half_squares: NDArray[np.float32]
    samples: tuple[SurfaceSample, ...]

    @cached_property
    def axes(self) -> tuple[AxisMeasures, ...]:
        """Measures of the medial axes."""
        return tuple(measure_axis(sample) for sample in self.samples)

    @cached_property
    def distances(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(b, k, k) distances between the keypoints of each candidate, and between their ball centres."""
        keypoints = self.descriptors.shape[1]
        return point_distances(self.points[:, :keypoints]), point_distances(self.centers[:, :keypoints])

    @classmethod
    def of(cls, samples: Sequence[SurfaceSample]) -> SampleStack:
        """Stack samples.

        Parameters
        ----------
        samples : sequence of SurfaceSample
            At least one; see `alike`.

        Returns
        -------
        stack : SampleStack
        """
        points, normals, centers, descriptors = (
            np.stack([getattr(sample, name) for sample in samples]).astype(np.float32)
            for name in ("points", "normals", "centers", "descriptors")
        )
        half_squares = (descriptors**2).sum(axis=2) / 2
        lengths = np.stack([axis_lengths(sample) for sample in samples]).astype(np.float32)
        return cls(points, normals, centers, lengths, descriptors, half_squares, tuple(samples))


def alike(samples: Sequence[SurfaceSample]) -> list[list[int]]:
    """Group samples that can be stacked.

    Parameters
    ----------
    samples : sequence of SurfaceSample

    Returns
    -------
    groups : list of list of int
        Positions of samples with equal numbers of points and of keypoints. Few point clouds have fewer than
        others.
    """
    groups: dict[tuple[int, int], list[int]] = {}
    for position, sample in enumerate(samples):
        groups.setdefault((len(sample.points), len(sample.descriptors)), []).append(position)
    return list(groups.values())
