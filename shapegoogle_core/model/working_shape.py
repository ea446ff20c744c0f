# SPDX-License-Identifier: MIT
"""From a mesh as read to a shape at the model's resolution and area, with its spectrum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import POINT_CLOUD, build_operator
from shapegoogle_core.mesh import Mesh, check_cloud, check_surface
from shapegoogle_core.mesh.connectivity import used_vertices
from shapegoogle_core.mesh.measures import bounding_box
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.preprocessing import Preprocessed, Unsmoothed, preprocess_in_steps, repair
from shapegoogle_core.spectral import Spectrum, compute_spectrum

__all__ = ["Placement", "WorkingShape", "prepare", "working_shape"]


@dataclass(frozen=True, eq=False)
class Placement:
    """Transformation from a mesh as given to the prepared one: x ↦ scale · (x - origin).

    Attributes
    ----------
    origin : (3,) array
        In the unit of the mesh as given.
    scale : float
    """

    origin: FloatArray
    scale: float

    def apply(self, points: FloatArray) -> FloatArray:
        """Transform points of the mesh as given.

        Parameters
        ----------
        points : (n, 3) array

        Returns
        -------
        transformed : (n, 3) array
        """
        return np.asarray((points - self.origin) * self.scale)

    def restore(self, mesh: Mesh) -> Mesh:
        """Move a prepared mesh back to where the mesh as given was.

        Parameters
        ----------
        mesh : Mesh

        Returns
        -------
        restored : Mesh
        """
        return Mesh(mesh.vertices / self.scale + self.origin, mesh.faces, mesh.name)


@dataclass(frozen=True, eq=False)
class WorkingShape:
    """Shape at the working resolution and area.

    Attributes
    ----------
    mesh : Mesh
        See `prepare`. A point cloud has its areas in the spectrum's `mass`.
    spectrum : Spectrum
        Spectrum of that mesh.
    placement : Placement
        Transformation from the mesh as given.
    unsmoothed : Unsmoothed or None
        The mesh before it was smoothed, if that is known.
    """

    mesh: Mesh
    spectrum: Spectrum
    placement: Placement
    unsmoothed: Unsmoothed | None = None


def prepare(settings: ModelSettings, mesh: Mesh) -> tuple[Preprocessed, Placement]:
    """Preprocess a mesh or a point cloud, and scale it to the working area.

    Parameters
    ----------
    settings : ModelSettings
    mesh : Mesh

    Returns
    -------
    prepared : Preprocessed
        Its mesh has the area `settings.area` and is centred on its bounding box. A point cloud stays one.
    placement : Placement
        Transformation from the mesh as given.

    Raises
    ------
    MeshError
        If the shape cannot be described (see `check_surface` and `check_cloud`), or has no area after repair.
    """
    if mesh.is_point_cloud:
        check_cloud(mesh)
        vertices, faces = mesh.vertices, None
    else:
        check_surface(mesh)
        # A vertex that no face uses must not influence the scale.
        used, faces = used_vertices(mesh.faces, len(mesh.vertices))
        vertices = mesh.vertices[used]
    low, high = bounding_box(vertices)
    # To unit size first: squares of very small or very large coordinates would leave the range of floats.
    origin, size = (low + high) / 2, float(np.linalg.norm(high - low))
    centered = Mesh((vertices - origin) / size, faces, mesh.name)
    if settings.preprocessing is None:
        repaired = repair(centered)
        steps = Preprocessed(repaired, Unsmoothed(repaired, np.empty((0, 3))))
    else:
        steps = preprocess_in_steps(centered, settings.preprocessing)
    if mesh.is_point_cloud:
        area = build_operator(steps.mesh, POINT_CLOUD).lumped_mass.sum()
    else:
        area = steps.mesh.area
    if not area > 0:
        raise MeshError(f"{mesh.name!r} has no surface left after repair: all faces are degenerate")
    scale = float(np.sqrt(settings.area / area))
    prepared = Preprocessed(
        Mesh(steps.mesh.vertices * scale, steps.mesh.faces, mesh.name),
        steps.unsmoothed.scaled(scale),
    )
    return prepared, Placement(origin, scale / size)


def working_shape(settings: ModelSettings, mesh: Mesh) -> WorkingShape:
    """Bring a mesh to the working resolution and area, and compute its spectrum.

    Parameters
    ----------
    settings : ModelSettings
        A point cloud always has the "point-cloud" operator, whatever the settings say.
    mesh : Mesh

    Returns
    -------
    shape : WorkingShape
        With at most `settings.eigenpairs` eigenpairs.

    Raises
    ------
    MeshError
        If the shape cannot be described, or its eigenproblem cannot be solved.
    """
    prepared, placement = prepare(settings, mesh)
    laplacian = POINT_CLOUD if mesh.is_point_cloud else settings.laplacian
    spectrum = compute_spectrum(prepared.mesh, settings.eigenpairs, laplacian, settings.boundary)
    return WorkingShape(prepared.mesh, spectrum, placement, prepared.unsmoothed)
