# SPDX-License-Identifier: MIT
"""The steps of preprocessing in their order; every shape passes them before it is described."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shapegoogle_core.api.arguments import check_count, check_number
from shapegoogle_core.mesh.checks import check_cloud, check_surface
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.mesh.mesh_like import MeshLike, as_mesh
from shapegoogle_core.preprocessing.fans import separate_fans
from shapegoogle_core.preprocessing.holes import boundary_half_edges, close_holes
from shapegoogle_core.preprocessing.openings import opening_points
from shapegoogle_core.preprocessing.repair import repair
from shapegoogle_core.preprocessing.resampling import resample
from shapegoogle_core.preprocessing.smoothing import smooth

__all__ = ["Preprocessed", "PreprocessingSettings", "Unsmoothed", "preprocess", "preprocess_in_steps"]


@dataclass(frozen=True)
class PreprocessingSettings:
    """Settings of `preprocess`.

    Parameters
    ----------
    close_holes : float
        Largest width of a hole that is closed, as a share of the bounding-box diagonal, from 0 to 1; 0 closes
        none. Not used for point clouds.
    floor : int
        Fewest vertices: a coarser surface is subdivided. Not used for point clouds.
    budget : int
        Most vertices, 4 at least: a finer surface or point cloud is simplified.
    longest_edge : float
        Longest edge, as a share of the square root of the area; longer ones are split. Before that, surfaces
        that touch in a single vertex are separated, and vertices that the surface does not need are removed:
        then it does not matter how it is cut into triangles. 0 does none of this, as in models from before
        it existed. Not used for point clouds.
    smoothing : float
        Time of the smoothing step as a share of the area (see `smooth`); 0 leaves the surface as it is.

    Raises
    ------
    ValueError
        If a value is out of range.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> sg.PreprocessingSettings(budget=2000)
    PreprocessingSettings(close_holes=0.45, floor=1000, budget=2000, longest_edge=0.045, smoothing=0.0003)
    """

    close_holes: float = 0.45
    floor: int = 1000
    budget: int = 5000
    longest_edge: float = 0.045
    smoothing: float = 3e-4

    def __post_init__(self) -> None:
        check_number("close_holes", self.close_holes, most=1)
        check_count("floor", self.floor, 0)
        check_count("budget", self.budget, 4)
        check_number("longest_edge", self.longest_edge)
        check_number("smoothing", self.smoothing)


_DEFAULT = PreprocessingSettings()


def preprocess(mesh: MeshLike, settings: PreprocessingSettings = _DEFAULT) -> Mesh:
    """Repair a shape, close its holes, bring it to a working resolution and smooth it.

    Two meshes of the same surface give nearly the same result, however they cut it into triangles.

    Parameters
    ----------
    mesh : MeshLike
        A surface or a point cloud, as read from a file. The points of a cloud are welded, thinned and
        smoothed; they have no holes.
    settings : PreprocessingSettings, optional
        Settings of the steps; by default those of the shipped model.

    Returns
    -------
    preprocessed : Mesh
        With `budget` vertices at most.

    Raises
    ------
    MeshError
        If the shape cannot be described, before or after repair (see `check_surface` and `check_cloud`), or
        a point cloud has no Laplacian to be smoothed with.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> sg.preprocess(trimesh.creation.icosphere(subdivisions=5), sg.PreprocessingSettings(budget=2000))
    Mesh('mesh', 2000 vertices, 3996 faces)
    """
    return preprocess_in_steps(mesh, settings).mesh


@dataclass(frozen=True, eq=False)
class Unsmoothed:
    """A surface before it is smoothed. A part is smoothed less than its whole, as its area is smaller.

    Attributes
    ----------
    mesh : Mesh
    openings : (p, 3) array
        Points of the boundary and of the lids of holes if something is cut off, see `opening_points`.
    """

    mesh: Mesh
    openings: FloatArray

    def scaled(self, factor: float) -> Unsmoothed:
        """Return the surface with all lengths multiplied by a factor.

        Parameters
        ----------
        factor : float

        Returns
        -------
        unsmoothed : Unsmoothed
        """
        mesh = Mesh(self.mesh.vertices * factor, self.mesh.faces, self.mesh.name)
        return Unsmoothed(mesh, self.openings * factor)


@dataclass(frozen=True, eq=False)
class Preprocessed:
    """A preprocessed shape, and what is lost on the way.

    Attributes
    ----------
    mesh : Mesh
        The result of all steps.
    unsmoothed : Unsmoothed
        The same vertices and faces before the last step.
    """

    mesh: Mesh
    unsmoothed: Unsmoothed


def preprocess_in_steps(mesh: MeshLike, settings: PreprocessingSettings = _DEFAULT) -> Preprocessed:
    """Preprocess a shape like `preprocess`, and keep what a later step has removed.

    Parameters
    ----------
    mesh : MeshLike
        A surface or a point cloud, as read from a file.
    settings : PreprocessingSettings, optional
        Settings of the steps; by default those of the shipped model.

    Returns
    -------
    preprocessed : Preprocessed

    Raises
    ------
    MeshError
        As `preprocess`.
    """
    mesh = as_mesh(mesh)
    is_cloud = mesh.is_point_cloud
    check = check_cloud if is_cloud else check_surface
    check(mesh)
    repaired = repair(mesh)
    openings = np.empty((0, 3))
    if not is_cloud:
        if repaired is not mesh:
            check(repaired)  # repair drops faces without area, which may be all
        boundary, face_count = boundary_half_edges(repaired), len(repaired.faces)
        repaired = close_holes(repaired, settings.close_holes, boundary)
        openings = opening_points(repaired, boundary[0], repaired.faces[face_count:])
        if settings.longest_edge > 0:
            repaired = separate_fans(repaired)
    mesh = resample(repaired, settings.floor, settings.budget, settings.longest_edge)
    if is_cloud:
        check(mesh)  # points that crowd in few places become few points
    return Preprocessed(smooth(mesh, settings.smoothing), Unsmoothed(mesh, openings))
