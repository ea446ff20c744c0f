# SPDX-License-Identifier: MIT
"""Reading a mesh file object by object, where its format has objects that are made on their own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.checks import check_surface
from shapegoogle_core.mesh.io.polygons import triangulate, without_lost_points
from shapegoogle_core.mesh.io.reading import MAX_FACES, opened, read_with_warnings
from shapegoogle_core.mesh.io.three_mf import PlateObject, read_plate
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["MeshObject", "read_object", "read_objects"]

# Matrices are written with six decimals.
_SIMILAR = 1e-4


@dataclass(frozen=True, eq=False)
class MeshObject:
    """An object of a mesh file.

    Parameters
    ----------
    mesh : Mesh
        In the coordinates of the file, as the first place has it.
    object_name : str
        Its name in the file, different for each object; empty for a file that is one shape.
    matrices : tuple of (4, 4) array
        From its own coordinates to those of the file, for each time that the file shows it. Each is the first
        one with another motion and uniform scale, mirrored or not. Empty for a file that is one shape.
    warnings : tuple of str
        A sentence for each part of it that was left out.
    """

    mesh: Mesh
    object_name: str = ""
    matrices: tuple[FloatArray, ...] = ()
    warnings: tuple[str, ...] = ()


def read_objects(path: Path) -> Iterator[MeshObject | str]:
    """Read a mesh file object by object.

    Parameters
    ----------
    path : Path
        The objects of a .3mf are those of its plate; other files are one shape each.

    Yields
    ------
    found : MeshObject or str
        A sentence for an object that is no shape.

    Raises
    ------
    MeshError
        If the file cannot be read; see `read_mesh`.
    """
    if path.suffix.lower() != ".3mf":
        mesh, warnings = read_with_warnings(path)
        yield MeshObject(mesh, warnings=warnings)
        return
    with opened(path, MAX_FACES) as file:
        plate = read_plate(file)
    entries = list(_entries(plate))
    for found, name in zip(entries, _names(entries, path), strict=True):
        try:
            with opened(path, MAX_FACES):
                polygons = without_lost_points(found.placed(found.matrices[0]))
                faces = triangulate(polygons, MAX_FACES)
            # A plate of one object is found by the name of its file.
            mesh = Mesh(polygons.vertices, faces, name if len(entries) > 1 else path.name)
            check_surface(mesh)
        except MeshError as error:
            yield str(error)
            continue
        warnings = tuple(f"{path.name!r}: {name!r} {note}" for note in polygons.notes)
        yield MeshObject(mesh, name, tuple(found.matrices), warnings)


def read_object(path: Path, object_name: str) -> Mesh:
    """Read one object of a mesh file.

    Parameters
    ----------
    path : Path
    object_name : str
        As `read_objects` gives it; ignored for a file that is one shape.

    Returns
    -------
    mesh : Mesh
        In its first place.

    Raises
    ------
    MeshError
        If the file cannot be read or the object is not there.
    """
    for found in read_objects(path):
        if isinstance(found, MeshObject) and found.object_name in ("", object_name):
            return found.mesh
    raise MeshError(f"{path.name!r} has no object {object_name!r} any more; index it again")


def _entries(plate: list[PlateObject]) -> Iterator[PlateObject]:
    """Split objects that are built with different stretching: these are different shapes."""
    for found in plate:
        groups: list[list[FloatArray]] = []
        for matrix in found.matrices:
            group = next((group for group in groups if _are_similar(group[0], matrix)), None)
            if group is None:
                groups.append([matrix])
            else:
                group.append(matrix)
        for group in groups:
            yield replace(found, matrices=group)


def _are_similar(first: FloatArray, second: FloatArray) -> bool:
    """Whether a motion with a uniform scale, mirrored or not, leads from one place to the other."""
    if np.linalg.det(first[:3, :3]) == 0:
        return bool(np.array_equal(first, second))
    relation = second[:3, :3] @ np.linalg.inv(first[:3, :3])
    squares = relation.T @ relation
    return bool(np.allclose(squares, np.eye(3) * np.trace(squares) / 3, atol=_SIMILAR * np.trace(squares)))


def _names(entries: list[PlateObject], path: Path) -> list[str]:
    """Names of objects, each once; those without one are numbered."""
    if len(entries) == 1:
        return [entries[0].name or path.stem]
    names: list[str] = []
    for number, found in enumerate(entries, start=1):
        wanted = found.name or f"Object {number}"
        name, copy = wanted, 2
        while name in names:
            name, copy = f"{wanted} ({copy})", copy + 1
        names.append(name)
    return names
