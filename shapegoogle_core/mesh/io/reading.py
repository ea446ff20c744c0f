# SPDX-License-Identifier: MIT
"""Reading a mesh file: one shape per file, or a sentence that says why not."""

from __future__ import annotations

import io
import logging
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.checks import check_cloud, check_surface
from shapegoogle_core.mesh.io.gltf import check_glb, check_gltf
from shapegoogle_core.mesh.io.obj import read_obj
from shapegoogle_core.mesh.io.pcd import check_point_count, read_pcd, read_xyz
from shapegoogle_core.mesh.io.ply import Checked, FormatError, check_off, check_ply, check_stl
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["MESH_SUFFIXES", "read_mesh"]

# What each file must pass before trimesh parses it.
_CHECKS: dict[str, Callable[[bytes, int], Checked]] = {
    ".ply": check_ply,
    ".stl": check_stl,
    ".off": check_off,
    ".glb": check_glb,
    ".gltf": check_gltf,
}

# Formats that trimesh reads too slowly, or not as they are meant.
_READERS: dict[str, Callable[[bytes, int], tuple[FloatArray, NDArray[np.int64]]]] = {".obj": read_obj}

# Formats of points alone; trimesh reads only plain ones of them.
_SCANS: dict[str, Callable[[bytes, int], FloatArray]] = {".xyz": read_xyz, ".pcd": read_pcd}

MESH_SUFFIXES = frozenset(_CHECKS) | frozenset(_READERS) | frozenset(_SCANS)
"""What `read_mesh` reads, in lower case with the dot."""

# Elsewhere vertices without faces are curves, or what an export has lost.
_MAY_HAVE_NO_FACES = frozenset(_SCANS) | {".ply"}

# A file is read as a whole. The longest spelling, a text STL, takes about 300 bytes a face; textures in a
# glTF come on top.
_BYTES_PER_FACE = 400
_OTHER_BYTES = 500_000_000

# How files that are often misnamed begin.
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


def read_mesh(
    path: str | os.PathLike[str], *, point_cloud: bool = False, max_faces: int = 20_000_000
) -> Mesh:
    """Read a mesh file, or the points of a scan, as one shape.

    All objects, groups and scene nodes of a file, each in its place, make one mesh; polygons become fans of
    triangles; materials, textures and animation are left out. A .ply without faces, an .xyz and a .pcd are
    read as points without faces. Nothing is fetched from a network.

    Parameters
    ----------
    path : path
        A file with one of the suffixes in `MESH_SUFFIXES`, in upper or lower case.
    point_cloud : bool, optional
        Read points alone, from files of any kind. Faces are left out if there are any.
    max_faces : int, optional
        A file with more triangles, or points without faces, is refused, by its header where it has one,
        before memory is taken for them.

    Returns
    -------
    mesh : Mesh
        In the file's unit; named after the file.

    Raises
    ------
    MeshError
        If the file is missing, unreadable, empty, damaged, cut short, of another format, too large, or
        holds no surface (see `check_surface`) nor points of one (`check_cloud`).
    """
    path = Path(path)
    name = path.name or str(path)
    suffix = path.suffix.lower()
    try:
        if not path.is_file():
            what = (
                "is a folder"
                if path.is_dir()
                else "is no ordinary file"
                if path.exists()
                else "does not exist"
            )
            raise MeshError(f"{str(path)!r} {what}; give the path of a mesh file")
        if suffix not in MESH_SUFFIXES:
            raise MeshError(
                f"{name!r} is none of the mesh files that can be read ({', '.join(sorted(MESH_SUFFIXES))}); "
                "convert it first"
            )
        if suffix in _SCANS:
            vertices = _SCANS[suffix](_read(path, max_faces), max_faces)
            faces = np.empty((0, 3), np.int64)
        elif suffix in _READERS:
            vertices, faces = _READERS[suffix](_read(path, max_faces), max_faces)
        else:
            checked = _CHECKS[suffix](_read(path, max_faces), max_faces)
            vertices, faces = _parse(checked.data, path, max_faces)
            if checked.faces is not None and checked.faces != len(faces):
                raise FormatError(
                    f"announces {checked.faces:,} triangles, but {len(faces):,} can be read; it is damaged "
                    "or was cut short: copy or export it again"
                )
        if not len(faces):
            check_point_count(len(vertices), max_faces)
    except MeshError:
        raise
    except FormatError as error:
        raise MeshError(f"{name!r} {error}{_misnamed(path)}") from error
    except IndexError as error:
        raise MeshError(
            f"{name!r} names a vertex or part that is not there ({error}); it is damaged or was cut short"
        ) from error
    except OSError as error:
        raise MeshError(
            f"{name!r} cannot be read: {error.strerror or error}; check the disk and its permissions"
        ) from error
    except MemoryError as error:
        raise MeshError(
            f"{name!r} does not fit into memory; simplify it, or lower max_faces to skip such files"
        ) from error
    except Exception as error:
        # Damaged files make parsers fail in every way; whatever it was, it is this file's fault.
        raise MeshError(f"{name!r} is damaged ({type(error).__name__}: {error}); export it again") from error
    if point_cloud:
        return _point_cloud(Mesh(vertices, name=name))
    mesh = Mesh(vertices, faces, name)
    if mesh.is_point_cloud and suffix in _MAY_HAVE_NO_FACES:
        check_cloud(mesh)
    else:
        check_surface(mesh)
    return mesh


def _read(path: Path, max_faces: int) -> bytes:
    size = path.stat().st_size
    if size == 0:
        raise FormatError("is empty (0 bytes); copy or export it again")
    if size > _OTHER_BYTES + _BYTES_PER_FACE * max_faces:
        raise FormatError(
            f"has {size:,} bytes, more than a mesh with the limit of {max_faces:,} faces takes; "
            "simplify it first, or raise max_faces"
        )
    return path.read_bytes()


def _parse(data: bytes, path: Path, max_faces: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Let trimesh parse a file."""
    import trimesh  # takes a second

    neighbours: Any = _Neighbours(path.parent, max_faces)
    with _quiet():
        scene = trimesh.load_scene(
            io.BytesIO(data),
            file_type=path.suffix[1:].lower(),
            resolver=neighbours,
            process=False,
            maintain_order=True,
            skip_materials=True,
        )
        return _flatten(scene)


def _flatten(scene: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Put all parts of a trimesh scene in their places and into one list of triangles."""
    vertices, faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    if scene.graph.nodes_geometry:
        placed = [scene.graph[node] for node in sorted(scene.graph.nodes_geometry)]
    else:  # a glTF without a scene; its meshes have no place
        placed = [(np.eye(4), name) for name in scene.geometry]
    for transform, name in placed:
        part = scene.geometry[name]
        points = np.asarray(part.vertices, np.float64)
        triangles = np.asarray(getattr(part, "faces", ()), np.int64).reshape(-1, 3)
        if triangles.size and (triangles.min() < 0 or triangles.max() >= len(points)):
            strange = triangles[(triangles < 0) | (triangles >= len(points))][0]
            raise FormatError(
                f"has a face that names vertex {strange}, but its part has {len(points):,} vertices "
                "(counted from 0); it is damaged or was cut short"
            )
        if not np.array_equal(transform, np.eye(4)):
            points = points @ transform[:3, :3].T + transform[:3, 3]
        vertices.append(points)
        mirrored = np.linalg.det(transform[:3, :3]) < 0
        faces.append((triangles[:, ::-1] if mirrored else triangles) + count)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(faces)


class _Neighbours:
    """What trimesh asks for the other files that a glTF names: regular files in its folder or below."""

    def __init__(self, folder: Path, max_faces: int) -> None:
        self.folder = folder.resolve()
        self.max_faces = max_faces

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def get(self, name: str) -> bytes:
        neighbour = (self.folder / unquote(name)).resolve()
        if not neighbour.is_relative_to(self.folder) or not neighbour.is_file():
            raise FormatError(f"needs the file {name!r}, which is not beside it; copy both together")
        return _read(neighbour, self.max_faces)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep trimesh's log and numpy's warnings off the user's terminal; what matters is raised."""
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # numpy before 2.4 only warns of numbers that it cannot read, and leaves the rest out.
            warnings.filterwarnings("error", message="string or file could not be read to its end")
            yield
    finally:
        log.setLevel(level)


def _point_cloud(points: Mesh) -> Mesh:
    if len(points.vertices) < 4:
        raise MeshError(f"{points.name!r} has only {len(points.vertices)} points; a shape needs at least 4")
    if not np.ptp(points.vertices, axis=0).any():
        raise MeshError(f"{points.name!r}: all points coincide; export it again")
    return points


def _misnamed(path: Path) -> str:
    """Say which format the file rather has, if its first bytes tell."""
    with path.open("rb") as file:
        head = file.read(16)
    for beginning, suffix in _BEGINNINGS.items():
        if head.startswith(beginning) and suffix != path.suffix.lower():
            return f" (it begins like a {suffix} file: perhaps it only has the wrong name)"
    return ""
