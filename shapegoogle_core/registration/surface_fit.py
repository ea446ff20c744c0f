# SPDX-License-Identifier: MIT
"""How exactly two surfaces lie on one another, once they are aligned: a fit of points to a surface.

Aligning compares samples with samples, whose points are never the same ones. Here the points of one shape are
fitted to the other's faces, so that copies come to rounding errors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree
from trimesh.triangles import closest_point

from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.registration.alignment import Frame, similarity_transformations
from shapegoogle_core.registration.gauss_newton import height_derivatives, step_of
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["Fit", "Surface", "TangentPlanes", "fit", "frame_between", "matched", "mirrored"]

# Lengths are in units of √area of the surface that points are fitted to.
# So many faces with the nearest centres are asked for the nearest point.
_NEAR_FACES = 6
# Robust weights exp(-(r/τ)²) of the steps: first what lies near, then what lies on it.
_TOLERANCES = (0.05, 0.03, 0.02, 0.01, 0.01, 0.005, 0.005, 0.005)
# A point of the surface is covered by the sample if it is this near to the tangent plane of the sample's
# nearest point, and if that one is no farther than the sample is wide apart.
_HEIGHT, _SPACING = 0.02, 0.08


class Surface:
    """Finds the nearest point of a mesh of even faces, in the units of its sample.

    Parameters
    ----------
    mesh : Mesh
        In the coordinates that the sample's centre and unit refer to.
    sample : SurfaceSample
        Of that mesh.
    """

    def __init__(self, mesh: Mesh, sample: SurfaceSample) -> None:
        vertices = (mesh.vertices - sample.center) / sample.unit
        self._triangles = vertices[mesh.faces]
        self._tree = cKDTree(self._triangles.mean(axis=1))
        self._count = min(_NEAR_FACES, len(mesh.faces))
        normals = np.cross(
            self._triangles[:, 1] - self._triangles[:, 0], self._triangles[:, 2] - self._triangles[:, 0]
        )
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        self._normals = normals / np.maximum(lengths, np.finfo(float).tiny)

    def nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nearest points of the surface.

        Parameters
        ----------
        points : (n, 3) array

        Returns
        -------
        nearest : (n, 3) array
        normals : (n, 3) array
            Of their faces.
        """
        _, faces = self._tree.query(points, self._count)
        faces = np.asarray(faces).reshape(len(points), -1)
        repeated = np.repeat(points, faces.shape[1], axis=0)
        closest = np.asarray(closest_point(self._triangles[faces.ravel()], repeated))  # type: ignore[no-untyped-call]
        closest = closest.reshape(*faces.shape, 3)
        best = ((closest - points[:, None]) ** 2).sum(axis=2).argmin(axis=1)
        rows = np.arange(len(points))
        return closest[rows, best], self._normals[faces[rows, best]]


class TangentPlanes:
    """Stands for a surface of which only a sample is known: the tangent planes at its points.

    Parameters
    ----------
    sample : SurfaceSample
    """

    def __init__(self, sample: SurfaceSample) -> None:
        self._points, self._normals = sample.points, sample.normals
        self._tree = cKDTree(sample.points)

    def nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nearest points of the planes at the nearest points; else as `Surface.nearest`."""
        _, places = self._tree.query(points)
        normals = self._normals[places]
        heights = ((points - self._points[places]) * normals).sum(axis=1)
        return points - heights[:, None] * normals, normals


@dataclass(frozen=True, eq=False)
class Fit:
    """A candidate's points where they fit the query's surface best.

    Attributes
    ----------
    frame : Frame
        From the candidate's sample to the query's.
    distances : (m,) array
        Of the candidate's points to the query's surface, in units of the query's √area.
    query_covered : float
        Share of the query's points that lie on the candidate, as far as its sample tells.
    """

    frame: Frame
    distances: FloatArray
    query_covered: float

    def covered(self, tolerance: float) -> float:
        """Share of the candidate's points that lie on the query's surface, to a tolerance."""
        return float((self.distances <= tolerance).mean())

    @property
    def deviation(self) -> float:
        """Distance that 95 % of the candidate's points do not exceed."""
        return float(np.quantile(self.distances, 0.95))


def frame_between(query: SurfaceSample, candidate: SurfaceSample) -> Frame:
    """Leave everything in its place: both samples in the coordinates of their files.

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

    Nothing that describes its points tells a shape from its reflection: only they and their normals change.

    Parameters
    ----------
    sample : SurfaceSample

    Returns
    -------
    reflected : SurfaceSample
    """
    flip = np.array([-1.0, 1.0, 1.0])
    return replace(sample, points=sample.points * flip, normals=sample.normals * flip)


def fit(
    surface: Surface | TangentPlanes,
    query: SurfaceSample,
    candidate: SurfaceSample,
    frame: Frame,
    *,
    steps: bool = True,
) -> Fit:
    """Fit the points of a candidate to the surface of the query.

    Gauss and Newton's method on the distances to tangent planes (Chen and Medioni 1992), with robust weights
    and the scale free.

    Parameters
    ----------
    surface : Surface or TangentPlanes
        Of the query.
    query, candidate : SurfaceSample
    frame : Frame
        To start from, see `Fit`.
    steps : bool, optional
        Without, measure only: the frame stays.

    Returns
    -------
    fit : Fit
    """
    for tolerance in _TOLERANCES if steps else ():
        points = frame.of(candidate.points)
        nearest, normals = surface.nearest(points)
        frame = _step(frame, points, nearest, normals, tolerance)
    points = frame.of(candidate.points)
    nearest, _ = surface.nearest(points)
    distances = np.linalg.norm(points - nearest, axis=1)
    return Fit(frame, distances, _covered(query.points, points, candidate.normals @ frame.rotation.T))


def matched(query: SurfaceSample, candidate: SurfaceSample) -> Fit:
    """Lay points of the same number over one another.

    A copy of a mesh, its vertices in the same order, is sampled at the same places. So this finds moved and
    scaled copies, and nothing else, at once.

    Parameters
    ----------
    query, candidate : SurfaceSample
        With as many points.

    Returns
    -------
    fit : Fit
        Distances are those of points of the same number.
    """
    scales, rotations, translations = similarity_transformations(
        candidate.points[None], query.points[None], np.ones((1, len(query.points)))
    )
    frame = Frame(float(scales[0]), rotations[0], translations[0])
    distances = np.linalg.norm(frame.of(candidate.points) - query.points, axis=1)
    return Fit(frame, distances, float((distances <= _HEIGHT).mean()))


def _step(
    frame: Frame, points: FloatArray, nearest: FloatArray, normals: FloatArray, tolerance: float
) -> Frame:
    offsets = nearest - points
    weights = np.exp(-(offsets**2).sum(axis=1) / (2 * tolerance**2))
    middle = (weights @ points) / max(weights.sum(), np.finfo(float).tiny)
    arms = points - middle
    columns = height_derivatives(arms, normals)
    heights = (offsets * normals).sum(axis=1)
    # What the surface does not tell, such as a turn of a sphere, stays as it is: the least solution.
    solution, *_ = np.linalg.lstsq(weights[:, None] * columns, weights * heights, rcond=1e-6)
    return step_of(frame, middle, solution, 0.8, 1.25)


def _covered(points: FloatArray, sample: FloatArray, normals: FloatArray) -> float:
    distances, nearest = cKDTree(sample).query(points)
    heights = np.abs(((points - sample[nearest]) * normals[nearest]).sum(axis=1))
    return float(((heights <= _HEIGHT) & (distances <= _SPACING)).mean())
