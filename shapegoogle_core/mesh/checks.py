# SPDX-License-Identifier: MIT
"""Checks that a surface or a point cloud can be described."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.connectivity import used_points, used_vertices
from shapegoogle_core.mesh.measures import bounding_box, box_sides, face_areas, vertex_areas
from shapegoogle_core.mesh.mesh import Mesh, counted
from shapegoogle_core.mesh.mesh_like import MeshLike, as_mesh

__all__ = ["FEWEST_POINTS", "REPAIR", "check_cloud", "check_surface", "check_used", "clean_surface"]

REPAIR = "repair it first, with shapegoogle_core.preprocessing.repair(mesh)"
"""The advice in errors about a mesh that repair makes usable."""

FEWEST_POINTS = 10
"""Fewest different points of a point cloud that can be described."""

# A cloud that is thinner in two directions than this share of its extent is a line.
_LEAST_WIDTH = 1e-6

# A surface with less area than this share of its squared extent is a line drawn with float32 rounding errors.
LEAST_RELATIVE_AREA = 1e-7


def check_surface(mesh: Mesh) -> None:
    """Raise unless the mesh is a surface that can be described.

    Parameters
    ----------
    mesh : Mesh

    Raises
    ------
    MeshError
        If there are no faces or fewer than four vertices, all points coincide, the surface has no area, or
        the coordinates are so large or small that areas overflow.
    """
    count = len(mesh.vertices)
    if mesh.is_point_cloud:
        raise MeshError(
            f"{mesh.name!r} has no faces and {counted(count, 'point', 'points')}, where a surface of "
            "triangles is needed: export the mesh with its faces"
        )
    if count < 4:
        raise MeshError(
            f"{mesh.name!r} has only {counted(count, 'vertex', 'vertices')}; a shape needs at least 4"
        )
    low, high = bounding_box(used_points(mesh.vertices, mesh.faces))
    with np.errstate(over="ignore"):
        extent = float((high - low).max())
    if extent <= 4 * np.finfo(np.float64).eps * float(np.abs([low, high]).max()):
        raise MeshError("{name!r}: all points of its faces coincide; export the mesh again", name=mesh.name)
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        area = mesh.area
        if 1e-100 < area < 1e100:
            relative_area = area / extent / extent  # the square may overflow
        else:  # rounded or out of range, where the shape itself may be sound
            scaled = face_areas(Mesh(mesh.vertices / extent, mesh.faces)) if extent < np.inf else np.zeros(1)
            relative_area = float(scaled.sum())
    if relative_area <= LEAST_RELATIVE_AREA and extent < np.inf:
        raise MeshError(
            "{name!r}: its faces have no area (all points lie on a line); export the mesh again",
            name=mesh.name,
        )
    if not 0 < area < np.inf:
        raise MeshError(
            f"{mesh.name!r} is {extent:g} units long, so that areas overflow; scale the mesh to a usual size"
        )


def check_used(mesh: Mesh) -> None:
    """Raise MeshError if a mesh has vertices that no face uses.

    Parameters
    ----------
    mesh : Mesh

    Raises
    ------
    MeshError
        If there are any.
    """
    unused = len(mesh.vertices) - len(used_vertices(mesh.faces, len(mesh.vertices))[0])
    if unused:
        vertices = counted(unused, "vertex", "vertices")
        raise MeshError(f"{mesh.name!r} has {vertices} that no face uses; {REPAIR}")


def clean_surface(shape: MeshLike) -> Mesh:
    """Convert to a mesh on which descriptors of surfaces are defined.

    Parameters
    ----------
    shape : MeshLike

    Returns
    -------
    mesh : Mesh

    Raises
    ------
    MeshError
        If it is not a mesh, not a surface (see `check_surface`), or a vertex has no area.
    """
    mesh = as_mesh(shape)
    check_surface(mesh)
    check_used(mesh)
    if not (vertex_areas(mesh) > 0).all():
        raise MeshError(f"{mesh.name!r} has vertices without area; {REPAIR}")
    return mesh


def check_cloud(mesh: Mesh) -> None:
    """Raise unless the vertices are a point cloud that can be described.

    Parameters
    ----------
    mesh : Mesh
        Faces are ignored.

    Raises
    ------
    MeshError
        If there are fewer than ten different points, all lie on a line, or the coordinates are so large or
        small that areas leave the range of floating-point numbers.
    """
    count = len(np.unique(mesh.vertices, axis=0))
    if count < FEWEST_POINTS:
        different = "" if count == len(mesh.vertices) else f", only {count} distinct"
        raise MeshError(
            f"{mesh.name!r} has no faces and {len(mesh.vertices)} points{different}; a point cloud needs at "
            f"least {FEWEST_POINTS}, a mesh its faces: export it again"
        )
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        extent = box_sides(mesh.vertices).max()
        area = extent**2
    if not 0 < area < np.inf:
        raise MeshError(
            f"{mesh.name!r} is {extent:g} units long, so that areas overflow; "
            "scale the points to a usual size"
        )
    centered = (mesh.vertices - mesh.vertices.mean(axis=0)) / extent
    widths = np.sqrt(np.maximum(np.linalg.eigvalsh(centered.T @ centered / len(centered)), 0))
    if widths[1] < max(_LEAST_WIDTH, 8 * np.finfo(float).eps * np.abs(mesh.vertices).max() / extent):
        raise MeshError(
            "{name!r}: all its points lie on a line; a shape needs points of a surface", name=mesh.name
        )
