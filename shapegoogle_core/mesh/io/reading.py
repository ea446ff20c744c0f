# SPDX-License-Identifier: MIT
"""Reading a mesh file of any format: `read_mesh` and the table of readers."""

from __future__ import annotations

import functools
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import cast

import numpy as np

from shapegoogle_core.api.arguments import as_path, check_count
from shapegoogle_core.api.registry import Plugin, PluginShapeError, Registry, check_takes
from shapegoogle_core.errors import MeshError, MeshWarning, PluginError
from shapegoogle_core.mesh.checks import check_cloud, check_surface
from shapegoogle_core.mesh.io.file import FormatError, MeshFile, check_point_count, read_content
from shapegoogle_core.mesh.io.gltf import read_glb, read_gltf
from shapegoogle_core.mesh.io.obj import read_obj
from shapegoogle_core.mesh.io.off import read_off
from shapegoogle_core.mesh.io.other_formats import advice
from shapegoogle_core.mesh.io.pcd import read_pcd
from shapegoogle_core.mesh.io.ply import read_ply
from shapegoogle_core.mesh.io.polygons import Polygons, triangulate, without_lost_points
from shapegoogle_core.mesh.io.stl import read_stl
from shapegoogle_core.mesh.io.three_mf import read_three_mf
from shapegoogle_core.mesh.io.xyz import read_xyz
from shapegoogle_core.mesh.mesh import Mesh

__all__ = ["MAX_FACES", "MESH_SUFFIXES", "READERS", "opened", "read_mesh", "read_with_warnings"]

Reader = Callable[[MeshFile], Polygons]


def _from_plugin(value: object, plugin: Plugin) -> Reader:
    check_takes(value, plugin, ("file",))
    reader = cast(Callable[[MeshFile], object], value)

    @functools.wraps(reader)
    def checked(file: MeshFile) -> Polygons:
        polygons = reader(file)
        if not isinstance(polygons, Polygons):
            raise plugin.unfit("return Polygons")
        return polygons

    return checked


READERS: Registry[Reader] = Registry(
    "mesh format",
    "shapegoogle.mesh_formats",
    {
        ".3mf": read_three_mf,
        ".glb": read_glb,
        ".gltf": read_gltf,
        ".obj": read_obj,
        ".off": read_off,
        ".pcd": read_pcd,
        ".ply": read_ply,
        ".stl": read_stl,
        ".xyz": read_xyz,
    },
    _from_plugin,
    prefix=".",
)
"""Reader of each format, by the suffix of its files in lower case with the dot."""

MESH_SUFFIXES = frozenset(READERS.own)
"""Suffixes of the files that `read_mesh` reads without plug-ins, in lower case with the dot."""

MAX_FACES = 20_000_000
"""Largest number of triangles, or of points, of a file that is read unless another one is given."""

# In other formats vertices without faces are curves, or the faces were lost in the export.
_MAY_HAVE_NO_FACES = frozenset({".glb", ".gltf", ".pcd", ".ply", ".xyz"})

# First bytes of files that often have a wrong name.
_BEGINNINGS = {
    b"ply": ".ply",
    b"glTF": ".glb",
    b"OFF": ".off",
    b"COFF": ".off",
    b"BLENDER": ".blend",
    b"Kaydara FBX": ".fbx",
    b"PK\x03\x04": ".zip",
    b"\x1f\x8b": ".gz",
}


def read_mesh(path: str | os.PathLike[str], *, point_cloud: bool = False, max_faces: int = MAX_FACES) -> Mesh:
    """Read a mesh file, or the points of a scan, as one shape.

    All objects, groups and scene nodes of a file, each in its place, make one mesh. Polygons, also concave
    ones, are cut into triangles that cover the same surface. Materials, textures and animation are left out.
    A .ply without faces, a .glb or .gltf of points, an .xyz and a .pcd give a point cloud. Points without
    finite coordinates, and faces that use them, are left out with a warning. Nothing is fetched from a
    network.

    Parameters
    ----------
    path : str or path
        A file with the suffix .3mf, .glb, .gltf, .obj, .off, .pcd, .ply, .stl or .xyz, or that of a
        plug-in, in upper or lower case. "~" stands for the user's own folder.
    point_cloud : bool, optional
        Read the points alone, from a file of any format.
    max_faces : int, optional
        Largest number of triangles, or of points without faces. A file with more is refused before memory
        is taken for them, if it has a header.

    Returns
    -------
    mesh : Mesh
        In the unit of the file (of a 3MF, which states its unit: in millimetres), with the file's name.

    Raises
    ------
    ValueError
        If the path is not one, or max_faces is not a whole number ≥ 1.
    MeshError
        If the file is missing, unreadable, empty, damaged, cut short, of another format, too large, or
        has neither a surface (see `check_surface`) nor points of one (`check_cloud`).

    Warns
    -----
    MeshWarning
        If a part of the file was left out.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import tempfile, trimesh
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = f"{folder}/box.ply"
    ...     _ = trimesh.creation.box((1, 2, 3)).export(path)
    ...     mesh = sg.read_mesh(path)
    >>> mesh, mesh.area
    (Mesh('box.ply', 8 vertices, 12 faces), 22.0)
    """
    mesh, sentences = read_with_warnings(path, point_cloud=point_cloud, max_faces=max_faces)
    for sentence in sentences:
        warnings.warn(sentence, MeshWarning, stacklevel=2)
    return mesh


def read_with_warnings(
    path: str | os.PathLike[str], *, point_cloud: bool = False, max_faces: int = MAX_FACES
) -> tuple[Mesh, tuple[str, ...]]:
    """Read a mesh file and return its warnings, for programs that show them in their own way.

    Parameters
    ----------
    path, point_cloud, max_faces
        As in `read_mesh`.

    Returns
    -------
    mesh : Mesh
    warnings : tuple of str
        A sentence for each part of the file that was left out.

    Raises
    ------
    ValueError, MeshError
        As in `read_mesh`.
    """
    check_count("max_faces", max_faces)
    path = as_path(path)
    with opened(path, max_faces) as file:
        polygons = without_lost_points(READERS[path.suffix.lower()](file))
        vertices, faces = polygons.vertices, triangulate(polygons, max_faces)
        if not len(faces):
            check_point_count(len(vertices), max_faces)
    sentences = tuple(f"{path.name!r} {note}" for note in polygons.notes)
    if point_cloud:
        return _point_cloud(Mesh(vertices, name=path.name)), sentences
    mesh = Mesh(vertices, faces, path.name)
    may_have_no_faces = path.suffix.lower() in _MAY_HAVE_NO_FACES or READERS.plugin(path.suffix.lower())
    if mesh.is_point_cloud and may_have_no_faces:
        check_cloud(mesh)
    else:
        check_surface(mesh)
    return mesh, sentences


@contextmanager
def opened(path: Path, max_faces: int) -> Iterator[MeshFile]:
    """Open a mesh file; errors within the block become a `MeshError` that names it."""
    name, suffix = path.name or str(path), path.suffix.lower()
    try:
        if not path.is_file():
            fault = "does not exist"
            if path.exists():
                fault = "is a folder" if path.is_dir() else "is not a regular file"
            raise MeshError(f"{str(path)!r} {fault}; give the path of a mesh file")
        if suffix not in READERS:
            known = ", ".join(sorted(READERS))
            unknown = f"has none of the suffixes that can be read ({known}); convert it first"
            raise MeshError(f"{name!r} {advice(suffix) or unknown}")
        yield MeshFile(read_content(path, max_faces), path.parent, max_faces)
    except MeshError:
        raise
    except FormatError as error:
        raise MeshError(f"{name!r} {error}{_misnamed(path)}") from error
    except OSError as error:
        raise MeshError(
            f"{name!r} cannot be read: {error.strerror or 'the system refuses'}; check the disk and its "
            "permissions"
        ) from error
    except MemoryError as error:
        raise MeshError(
            f"{name!r} does not fit into memory; simplify it, or lower max_faces to skip such files"
        ) from error
    except PluginError as error:
        raise PluginShapeError(f"{name!r} cannot be read: {error}") from error
    except Exception as error:
        plugin = READERS.plugin(suffix)
        if plugin is not None:
            raise PluginShapeError(
                f"{name!r} cannot be read by {plugin.title}; export it again, or report it to the authors of "
                "the package"
            ) from error
        # Damaged files can be wrong in ways that no reader expects; the cause is always this file.
        raise MeshError(
            f"{name!r} is damaged, cut short, or uses a feature that cannot be read; export it again"
        ) from error


def _point_cloud(points: Mesh) -> Mesh:
    if len(points.vertices) < 4:
        raise MeshError(f"{points.name!r} has only {len(points.vertices)} points; a shape needs at least 4")
    if not np.ptp(points.vertices, axis=0).any():
        raise MeshError(f"{points.name!r}: all points coincide; export it again")
    return points


def _misnamed(path: Path) -> str:
    """Name the format of the file if its first bytes are those of another one."""
    with path.open("rb") as file:
        head = file.read(16)
    own = ".zip" if path.suffix.lower() == ".3mf" else path.suffix.lower()  # a 3MF is a zip
    for beginning, suffix in _BEGINNINGS.items():
        if head.startswith(beginning) and suffix != own:
            return f" (it begins like a {suffix} file: perhaps it only has the wrong name)"
    return ""
