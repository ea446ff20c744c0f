# SPDX-License-Identifier: MIT
"""Measures of a medial axis that do not depend on how thick the limbs around it are.

A tube has an area of 2π r for each unit of length of its axis, and the points of a sample are evenly spread
over the area. So each centre of a medial ball counts with 1 / r: a limb that swells keeps the length of its
axis, and what is measured along it keeps its size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.point_distances import point_distances
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["AxisMeasures", "axis_lengths", "measure_axis"]

# Number of centres whose distances are measured: evenly spread like all first points of a sample.
_CENTERS = 160
# Smaller balls are noise; a ball of almost the largest radius touches nothing on the other side.
_SMALLEST_RADIUS, _OPEN_RADIUS = 0.02, 0.45


@dataclass(frozen=True, eq=False)
class AxisMeasures:
    """Measures of one medial axis, in the units of the sample.

    Attributes
    ----------
    size : float
        Mean distance of two points of the axis.
    center : (3,) array
        Centre of mass of the axis.
    axes : (3, 3) array
        Its principal axes, longest first, as rows; a rotation.
    """

    size: float
    center: FloatArray
    axes: FloatArray


def axis_lengths(sample: SurfaceSample) -> FloatArray:
    """Compute the length of the axis that each centre stands for.

    Parameters
    ----------
    sample : SurfaceSample

    Returns
    -------
    lengths : (m,) array
        As multiples of their mean; 0 where a ball touches nothing on the other side.
    """
    radii = np.abs(sample.radii)
    lengths = np.where(radii < _OPEN_RADIUS, 1 / np.maximum(radii, _SMALLEST_RADIUS), 0)
    if np.count_nonzero(lengths[:_CENTERS]) < 2:  # a flat or open surface has no axis, only itself
        return np.ones(len(radii))
    return np.asarray(lengths / lengths.mean())


def measure_axis(sample: SurfaceSample) -> AxisMeasures:
    """Measure the medial axis of a sample.

    Parameters
    ----------
    sample : SurfaceSample

    Returns
    -------
    measures : AxisMeasures
    """
    weights = axis_lengths(sample) / len(sample.radii)
    center = weights @ sample.centers
    offsets = sample.centers - center
    _, axes = np.linalg.eigh((weights[:, None] * offsets).T @ offsets)
    axes = axes.T[::-1].copy()
    axes[2] *= np.sign(np.linalg.det(axes))
    few = weights[:_CENTERS]
    distances = point_distances(sample.centers[:_CENTERS].astype(np.float32))
    others = max(few.sum() ** 2 - few @ few, np.finfo(float).tiny)
    return AxisMeasures(max(float(few @ distances @ few) / others, 1e-6), center, axes)
