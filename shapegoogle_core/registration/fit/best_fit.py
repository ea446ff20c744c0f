# SPDX-License-Identifier: MIT
"""The position in which two surfaces lie on each other best, to show them side by side."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from shapegoogle_core.mesh.mesh import Mesh
from shapegoogle_core.registration.aligning.align import align
from shapegoogle_core.registration.fit.part_pose import PartPoses
from shapegoogle_core.registration.fit.surface_fit import (
    Fit,
    Surface,
    TangentPlanes,
    fit_surface,
    frame_between,
    mirrored,
)
from shapegoogle_core.registration.frames import Frame
from shapegoogle_core.registration.prepared_sample import PreparedSample
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["best_fit"]

# Distance, in units of the query's √area, from which a point counts as being on no surface.
_FAR = 0.1
# A position that is worse by less than this is preferred if it is earlier in the list.
_WORSE = 1e-3


def best_fit(
    query: SurfaceSample,
    surface: Mesh | None,
    candidate: SurfaceSample,
    *,
    reflected: bool = False,
    scale: float | None = None,
) -> Frame:
    """Find the position in which a candidate lies on a query best.

    Tried are: where both have it in their files, the positions of parts, and a thorough alignment; each is
    fitted to the surface.

    Parameters
    ----------
    query : SurfaceSample
    surface : Mesh or None
        Surface that the query's sample was taken from; without it the fit is coarser.
    candidate : SurfaceSample
    reflected : bool, optional
        Whether the candidate is a mirror image of the query.
    scale : float, optional
        Scale of the frame; found by the fit by default.

    Returns
    -------
    frame : Frame
        From the candidate's units to the query's, with a reflection if it was asked for.
    """
    planes = surface is None or surface.is_point_cloud
    target = TangentPlanes(query) if planes or surface is None else Surface(surface, query)
    sample = mirrored(candidate) if reflected else candidate
    starts = list(_starts(query, sample))
    if scale is not None:
        starts = [_scaled(frame, scale, sample) for frame in starts]
    fits = [fit_surface(target, query, sample, frame, keep_scale=scale is not None) for frame in starts]
    costs = [_cost(fitted) for fitted in fits]
    least = min(costs)
    best = next(fitted for fitted, cost in zip(fits, costs, strict=True) if cost <= least + _WORSE)
    if not reflected:
        return best.frame
    flip = np.diag([-1.0, 1.0, 1.0])
    return Frame(best.frame.scale, best.frame.rotation @ flip, best.frame.translation)


def _starts(query: SurfaceSample, candidate: SurfaceSample) -> Iterator[Frame]:
    yield frame_between(query, candidate)
    prepared, other = PreparedSample(query), PreparedSample(candidate, (1.0,))
    (pose,) = PartPoses(prepared).find([other])
    if pose.frame is not None:
        yield pose.frame
    aligned = align(prepared, other).frame
    yield aligned.inverse()


def _scaled(frame: Frame, scale: float, candidate: SurfaceSample) -> Frame:
    """Give a frame another scale, so that the centre of the candidate's points stays where it is."""
    center = frame.rotation @ candidate.points.mean(axis=0)
    return Frame(scale, frame.rotation, frame.translation + (frame.scale - scale) * center)


def _cost(fitted: Fit) -> float:
    both = fitted.distances, fitted.query_distances
    return float(sum(np.minimum(distances, _FAR).mean() for distances in both))
