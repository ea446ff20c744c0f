# SPDX-License-Identifier: MIT
"""Exact fit of a candidate's points to the surface of a query, once the two are aligned.

An alignment compares two samples, which never have the same points. Here the points of one shape are fitted
to the faces of the other, so that the distances of a copy are rounding errors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.registration.fit.nearest import TriangleTree
from shapegoogle_core.registration.frames import (
    Frame,
    height_derivatives,
    similarity_frame,
    stepped,
)
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = [
    "Fit",
    "Surface",
    "TangentPlanes",
    "best_frame",
    "fit_numbered",
    "fit_surface",
    "frame_between",
    "measured",
    "mirrored",
]

# All lengths in this module are in units of the query's √area.
# Steps of the fit: number of the candidate's points, which are spread evenly, and tolerance τ of the robust
# weights exp(-r²/2τ²).
_STEPS = (
    (150, 0.05),
    (150, 0.03),
    (150, 0.02),
    (300, 0.01),
    (300, 0.005),
    (600, 0.005),
)
# With a larger tolerance the nearest point need not be exact; farther than this many times the tolerance it
# has no weight.
_ROUGHLY, _REACH = 0.02, 4
# Distances above this many times the reach need not be exact: such points lie on no surface.
_MEASURED = 0.01
# A point of the query is covered if it is this near to the tangent plane of the candidate's nearest point,
# and if that point is not much farther than the spacing of the sample.
_HEIGHT, _SPACING = 0.02, 0.08


class Surface:
    """Nearest points of a mesh, in the units of its sample.

    Parameters
    ----------
    mesh : Mesh
        In the coordinates that the sample's centre and unit refer to.
    sample : SurfaceSample
        Sample of that mesh.

    Attributes
    ----------
    slack : float
        Largest error of a distance from a point that is only roughly the nearest.
    """

    def __init__(self, mesh: Mesh, sample: SurfaceSample) -> None:
        vertices = (mesh.vertices - sample.center) / sample.unit
        triangles = vertices[mesh.faces]
        self._tree = TriangleTree(triangles)
        self.slack = self._tree.largest

    def nearest(self, points: FloatArray, tolerance: float = np.inf) -> tuple[FloatArray, FloatArray]:
        """Find the nearest points of the surface.

        Parameters
        ----------
        points : (n, 3) array
        tolerance : float, optional
            Points that are many times farther get any point that is about as near; if it is large beside the
            faces, all do.

        Returns
        -------
        nearest : (n, 3) array
        normals : (n, 3) array
            Normals of the faces on which they lie.
        """
        if _ROUGHLY <= tolerance < np.inf:
            nearest, faces = self._tree.near(points)
        else:
            nearest, faces = self._tree.nearest(points, _REACH * tolerance)
        return nearest, self._tree.normals[faces]


class TangentPlanes:
    """Nearest points of the tangent planes of a sample, where its mesh is not at hand.

    Parameters
    ----------
    sample : SurfaceSample

    Attributes
    ----------
    slack : float
        As that of `Surface`; 0.
    """

    slack = 0.0

    def __init__(self, sample: SurfaceSample) -> None:
        self._points, self._normals = sample.points, sample.normals
        self._tree = cKDTree(sample.points)

    def nearest(self, points: FloatArray, _tolerance: float = np.inf) -> tuple[FloatArray, FloatArray]:
        """Find the nearest points on the tangent planes at the nearest points of the sample.

        Parameters
        ----------
        points : (n, 3) array
        _tolerance : float, optional
            The tolerance of `Surface.nearest`, which changes nothing here.

        Returns
        -------
        nearest, normals : (n, 3) arrays
            As from `Surface.nearest`.
        """
        _, places = self._tree.query(points)
        normals = self._normals[places]
        heights = ((points - self._points[places]) * normals).sum(axis=1)
        return points - heights[:, None] * normals, normals


@dataclass(frozen=True, eq=False)
class Fit:
    """Candidate in the position in which its points fit the query's surface best.

    Distances are measured when they are asked for: those from faces take as long as the fit.

    Attributes
    ----------
    frame : Frame
        From the candidate's sample to the query's.
    measure, measure_query : callable
        Compute the distances.
    """

    frame: Frame
    measure: Callable[[], FloatArray]
    measure_query: Callable[[], FloatArray]

    @cached_property
    def distances(self) -> FloatArray:
        """(m,) distances of the candidate's points from the query's surface."""
        return self.measure()

    @cached_property
    def query_distances(self) -> FloatArray:
        """(n,) distances of the query's points from the candidate's tangent planes.

        Infinite for points that are farther from its sample than the points of that are from each other.
        """
        return self.measure_query()

    @property
    def query_covered(self) -> float:
        """Share of the query's points that lie on the candidate."""
        return self.query_within(_HEIGHT)

    def query_within(self, tolerance: float) -> float:
        """Return the share of the query's points within a distance of the candidate."""
        return float((self.query_distances <= tolerance).mean())

    def covered(self, tolerance: float) -> float:
        """Return the share of the candidate's points within a distance of the query's surface."""
        return float((self.distances <= tolerance).mean())

    @property
    def deviation(self) -> float:
        """95th percentile of the distances."""
        return float(np.quantile(self.distances, 0.95))


def frame_between(query: SurfaceSample, candidate: SurfaceSample) -> Frame:
    """Return the frame between two samples whose shapes stay where their files have them.

    Parameters
    ----------
    query, candidate : SurfaceSample

    Returns
    -------
    frame : Frame
        From the candidate's units to the query's.
    """
    return Frame(candidate.unit / query.unit, np.eye(3), (candidate.center - query.center) / query.unit)


def mirrored(sample: SurfaceSample) -> SurfaceSample:
    """Reflect a sample in the plane x = 0 of its own units.

    Only points and normals change: descriptors are the same for a shape and its mirror image.

    Parameters
    ----------
    sample : SurfaceSample

    Returns
    -------
    reflected : SurfaceSample
    """
    flip = np.array([-1.0, 1.0, 1.0])
    return replace(sample, points=sample.points * flip, normals=sample.normals * flip)


def fit_surface(
    surface: Surface | TangentPlanes,
    query: SurfaceSample,
    candidate: SurfaceSample,
    frame: Frame,
    *,
    steps: bool = True,
    keep_scale: bool = False,
) -> Fit:
    """Fit the points of a candidate to the surface of the query.

    Gauss-Newton iterations on the distances to tangent planes (Chen and Medioni 1992), with robust weights
    and a free scale.

    Parameters
    ----------
    surface : Surface or TangentPlanes
        Surface of the query.
    query, candidate : SurfaceSample
    frame : Frame
        Initial frame from the candidate to the query.
    steps : bool, optional
        False measures the distances without fitting.
    keep_scale : bool, optional
        Whether the fit only turns and moves the candidate.

    Returns
    -------
    fit : Fit
    """
    for count, tolerance in _STEPS if steps else ():
        points = frame.apply(candidate.points[:count])
        nearest, normals = surface.nearest(points, tolerance)
        frame = _step(frame, points, nearest, normals, tolerance, keep_scale=keep_scale)
    points = frame.apply(candidate.points)

    def measure() -> FloatArray:
        nearest, _ = surface.nearest(points, _MEASURED)
        return np.asarray(np.linalg.norm(points - nearest, axis=1))

    def measure_query() -> FloatArray:
        return _heights(query.points, points, candidate.normals @ frame.rotation.T)

    return Fit(frame, measure, measure_query)


def measured(surface: Surface | TangentPlanes, candidate: SurfaceSample, frame: Frame) -> float:
    """Measure the mean distance of a few points of a candidate from the query's surface.

    Parameters
    ----------
    surface : Surface or TangentPlanes
    candidate : SurfaceSample
    frame : Frame
        From the candidate to the query.

    Returns
    -------
    distance : float
    """
    return _mean_distance(surface, candidate, frame, _MEASURED)


def _mean_distance(
    surface: Surface | TangentPlanes, candidate: SurfaceSample, frame: Frame, tolerance: float
) -> float:
    points = frame.apply(candidate.points[: _STEPS[0][0]])
    return float(np.linalg.norm(points - surface.nearest(points, tolerance)[0], axis=1).mean())


def best_frame(surface: Surface | TangentPlanes, candidate: SurfaceSample, frames: Sequence[Frame]) -> Frame:
    """Choose the frame in which a few points of a candidate lie nearest to the query's surface.

    Parameters
    ----------
    surface : Surface or TangentPlanes
    candidate : SurfaceSample
    frames : sequence of Frame
        At least one, from the candidate to the query.

    Returns
    -------
    frame : Frame
        The one with the least `measured` distance. Most others are ruled out without measuring exactly.
    """
    roughly = [_mean_distance(surface, candidate, frame, _ROUGHLY) for frame in frames]
    limit = min(roughly) + surface.slack
    left = [frame for frame, distance in zip(frames, roughly, strict=True) if distance <= limit]
    return left[0] if len(left) == 1 else min(left, key=lambda frame: measured(surface, candidate, frame))


def fit_numbered(query: SurfaceSample, candidate: SurfaceSample) -> Fit:
    """Fit the i-th point of a candidate to the i-th point of the query, for all i.

    A copy of a mesh with its vertices in the same order is sampled at the same places. So this recognises
    moved and scaled copies at once, and nothing else.

    Parameters
    ----------
    query, candidate : SurfaceSample
        With the same number of points.

    Returns
    -------
    fit : Fit
        Its distances are those between points of the same number.
    """
    frame = similarity_frame(candidate.points, query.points, np.ones(len(query.points)))
    distances = np.linalg.norm(frame.apply(candidate.points) - query.points, axis=1)
    return Fit(frame, lambda: distances, lambda: distances)


def _step(
    frame: Frame,
    points: FloatArray,
    nearest: FloatArray,
    normals: FloatArray,
    tolerance: float,
    *,
    keep_scale: bool = False,
) -> Frame:
    offsets = nearest - points
    weights = np.exp(-(offsets**2).sum(axis=1) / (2 * tolerance**2))
    middle = (weights @ points) / max(weights.sum(), np.finfo(float).tiny)
    arms = points - middle
    columns = height_derivatives(arms, normals)
    if keep_scale:
        columns[:, 6] = 0  # the least-norm solution then does not scale
    heights = (offsets * normals).sum(axis=1)
    # The least-norm solution does not move along what the surface leaves free, such as a sphere's rotation.
    solution, *_ = np.linalg.lstsq(weights[:, None] * columns, weights * heights, rcond=1e-6)
    return stepped(frame, middle, solution, 0.8, 1.25)


def _heights(points: FloatArray, sample: FloatArray, normals: FloatArray) -> FloatArray:
    distances, nearest = cKDTree(sample).query(points)
    heights = np.abs(((points - sample[nearest]) * normals[nearest]).sum(axis=1))
    return np.where(distances <= _SPACING, heights, np.inf)
