# SPDX-License-Identifier: MIT
"""Find the motion and size with which one shape takes the place of another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.registration.aligning.align import align
from shapegoogle_core.registration.fit.part_pose import PartPoses
from shapegoogle_core.registration.fit.surface_fit import (
    Surface,
    TangentPlanes,
    fit_numbered,
    fit_surface,
    frame_between,
    measured,
    mirrored,
)
from shapegoogle_core.registration.frames import Frame, similarity_transformations
from shapegoogle_core.registration.measures.mesh_measures import MeshMeasures
from shapegoogle_core.registration.measures.same_mesh import (
    handed_alike,
    is_same_mesh,
    principal_motions,
)
from shapegoogle_core.registration.prepared_sample import PreparedSample
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["Laid", "lay_copy", "lay_on"]

# Of a copy, how far a vertex may end from its partner, in units of the extent: single precision.
_COPY = 1e-4
# A surface lies on another one if most points of both are this near, in units of the square root of the area.
_NEAR, _MOST = 0.04, 0.8
# A part lies on its whole more exactly.
_EXACT, _PART = 0.015, 0.85
# Positions that are fitted closely.
_CLOSELY = 3


@dataclass(frozen=True, eq=False)
class Laid:
    """A shape with what finding its place needs.

    Attributes
    ----------
    sample : SurfaceSample
    surface : Mesh or None
        Preprocessed, at its original place; without it the fit is coarser.
    measures : MeshMeasures or None
    """

    sample: SurfaceSample
    surface: Mesh | None = None
    measures: MeshMeasures | None = None


def lay_copy(target: FloatArray, vertices: FloatArray) -> FloatArray | None:
    """Find the motion of a copy whose vertices are in the same order; exact, and may mirror.

    Parameters
    ----------
    target, vertices : (n, 3) arrays
        Vertices of the shape whose place is taken, and of the copy.

    Returns
    -------
    matrix : (4, 4) array or None
        From the copy to the place; None if it is no such copy.

    Examples
    --------
    >>> import numpy as np
    >>> from shapegoogle_core.registration.fit.laying import lay_copy
    >>> points = np.random.default_rng(0).random((8, 3))
    >>> (lay_copy(2 * points + 1, points).round(6) + 0.0).tolist()[0]
    [2.0, 0.0, 0.0, 1.0]
    """
    if len(target) != len(vertices) or len(target) < 4:
        return None
    extent = float(np.linalg.norm(np.ptp(target, axis=0)))
    best: tuple[float, FloatArray] | None = None
    for sign in (1.0, -1.0):
        flipped = vertices * (sign, 1.0, 1.0)
        scales, turns, shifts = similarity_transformations(
            flipped[None], target[None], np.ones((1, len(target)))
        )
        linear = scales[0] * turns[0] * (sign, 1.0, 1.0)
        away = float(np.linalg.norm(vertices @ linear.T + shifts[0] - target, axis=1).max())
        if away <= _COPY * extent and (best is None or away < best[0]):
            best = away, _matrix(linear, shifts[0])
    return None if best is None else best[1]


def lay_on(target: Laid, shape: Laid) -> FloatArray | None:
    """Find the motion and size with which a shape lies on another one.

    Parameters
    ----------
    target : Laid
        The shape whose place is taken.
    shape : Laid

    Returns
    -------
    matrix : (4, 4) array or None
        Rotation or reflection, scale and translation, from the shape to its place; None if the two surfaces
        fit in no position that was tried, such as those of two chairs that are built differently.
    """
    surface: Surface | TangentPlanes = (
        TangentPlanes(target.sample) if target.surface is None else Surface(target.surface, target.sample)
    )
    best: tuple[float, FloatArray] | None = None
    for reflected in _handedness(target.measures, shape.measures):
        sample = mirrored(shape.sample) if reflected else shape.sample
        frames = sorted(
            _frames(target, shape, sample, reflected=reflected),
            key=lambda frame: measured(surface, sample, frame),
        )
        for frame in frames[:_CLOSELY]:
            fit = fit_surface(surface, target.sample, sample, frame)
            near = fit.covered(_NEAR), fit.query_within(_NEAR)
            fits = min(near) >= _MOST or max(fit.covered(_EXACT), fit.query_within(_EXACT)) >= _PART
            # Of a symmetric shape the image in the mirror fits as well: it is not taken without need.
            score = min(near) + max(near) - 0.05 * reflected
            if fits and (best is None or score > best[0]):
                best = score, _placed(target.sample, shape.sample, fit.frame, reflected=reflected)
    return None if best is None else best[1]


def _handedness(target: MeshMeasures | None, shape: MeshMeasures | None) -> tuple[bool, ...]:
    """Whether the mirror image is tried, alone or beside the shape itself."""
    if target is None or shape is None:
        return (False,)
    alike = handed_alike(target, shape)
    if is_same_mesh(target, shape):
        return (alike is False,)
    return (False, True) if alike is False else (False,)


def _frames(target: Laid, shape: Laid, sample: SurfaceSample, *, reflected: bool) -> Iterator[Frame]:
    """Positions worth a fit, from the units of the shape's sample, perhaps reflected, to the target's."""
    own = target.sample
    if not reflected:
        yield frame_between(own, sample)
    if len(sample.points) == len(own.points):
        yield fit_numbered(own, sample).frame
    if target.measures is not None and shape.measures is not None:
        flip = np.diag([-1.0, 1.0, 1.0]) if reflected else np.eye(3)
        for scale, turn, shift in principal_motions(target.measures, shape.measures, reflected=reflected):
            center = (scale * turn @ shape.sample.center + shift - own.center) / own.unit
            yield Frame(scale * shape.sample.unit / own.unit, turn @ flip, center)
    prepared = PreparedSample(own)
    yield align(prepared, PreparedSample(sample)).frame.inverse()
    (pose,) = PartPoses(prepared).find([PreparedSample(sample, (1.0,))])
    if pose.frame is not None:
        yield pose.frame


def _placed(target: SurfaceSample, shape: SurfaceSample, frame: Frame, *, reflected: bool) -> FloatArray:
    """Convert a frame between the units of two samples to a matrix between their coordinates."""
    turn = frame.rotation * (-1.0, 1.0, 1.0) if reflected else frame.rotation
    linear = target.unit * frame.scale / shape.unit * turn
    return _matrix(linear, target.center + target.unit * frame.translation - linear @ shape.center)


def _matrix(linear: FloatArray, shift: FloatArray) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, shift
    return matrix
