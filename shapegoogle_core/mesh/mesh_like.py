# SPDX-License-Identifier: MIT
"""Everything that is accepted where a mesh is expected: one adapter for other libraries' meshes."""

from __future__ import annotations

from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.mesh import Mesh

__all__ = ["MeshLike", "as_mesh", "is_mesh_like"]


class _VerticesAndFaces(Protocol):
    """Such as ``trimesh.Trimesh``."""

    @property
    def vertices(self) -> ArrayLike: ...

    @property
    def faces(self) -> ArrayLike | None: ...


class _LapyMesh(Protocol):
    """Such as ``lapy.TriaMesh``."""

    @property
    def v(self) -> ArrayLike: ...

    @property
    def t(self) -> ArrayLike: ...


MeshLike: TypeAlias = Mesh | tuple[ArrayLike, ArrayLike | None] | _VerticesAndFaces | _LapyMesh
"""A `Mesh`, a tuple ``(vertices, faces)``, or an object with ``.vertices``, ``.faces`` or ``.v``, ``.t``."""

_ACCEPTED = (
    "give a Mesh, a tuple (vertices, faces), or an object with .vertices and .faces (trimesh) "
    "or .v and .t (LaPy)"
)


def as_mesh(shape: MeshLike, name: str = "") -> Mesh:
    """Convert a mesh of any kind to a `Mesh`.

    Parameters
    ----------
    shape : MeshLike
        A `Mesh`, which is returned as it is; a tuple ``(vertices, faces)`` of arrays or nested sequences; or
        an object with the attributes ``vertices`` and ``faces`` (trimesh) or ``v`` and ``t`` (LaPy). Faces
        that are None or empty make a point cloud.
    name : str, optional
        Name of the new mesh in error messages; "mesh" by default. A `Mesh` keeps its own name.

    Returns
    -------
    mesh : Mesh

    Raises
    ------
    MeshError
        If `shape` is something else, or its arrays are not those of a mesh (see `Mesh`).

    Examples
    --------
    >>> from shapegoogle_core.mesh import as_mesh
    >>> as_mesh(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), name="triangle")
    Mesh('triangle', 3 vertices, 1 face)
    >>> import trimesh
    >>> as_mesh(trimesh.creation.box())
    Mesh('mesh', 8 vertices, 12 faces)
    """
    name = name or "mesh"
    if isinstance(shape, Mesh):
        return shape
    if isinstance(shape, tuple):
        if len(shape) == 2 and not any(map(is_mesh_like, shape)):
            return Mesh(*shape, name=name)
        raise MeshError(f"{name!r} is a tuple of {len(shape)} values, which is not one mesh; {_ACCEPTED}")
    for vertices, faces in (("vertices", "faces"), ("v", "t")):
        if hasattr(shape, vertices) and hasattr(shape, faces):
            return Mesh(getattr(shape, vertices), getattr(shape, faces), name)
    if isinstance(shape, str) or hasattr(shape, "__fspath__"):
        raise MeshError(f"{str(shape)!r} is a path and not a mesh; read the file with read_mesh(path)")
    raise MeshError(f"{name!r} is an object of the type {type(shape).__name__}, not a mesh; {_ACCEPTED}")


def is_mesh_like(shape: object) -> bool:
    """Decide whether an argument is one mesh (see `as_mesh`) and not a sequence of meshes.

    Parameters
    ----------
    shape : object

    Returns
    -------
    is_mesh : bool
        True for a `Mesh`, for objects with the attributes of one, and for a tuple of two values of which the
        first is a table of numbers. A list is always a sequence.

    Examples
    --------
    >>> from shapegoogle_core.mesh.mesh_like import is_mesh_like
    >>> triangle = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> is_mesh_like(triangle), is_mesh_like((triangle, triangle)), is_mesh_like([triangle])
    (True, False, False)
    """
    if isinstance(shape, tuple):
        return len(shape) == 2 and _is_table(shape[0])
    pairs = ("vertices", "faces"), ("v", "t")
    return any(hasattr(shape, vertices) and hasattr(shape, faces) for vertices, faces in pairs)


def _is_table(values: object) -> bool:
    """Decide whether values are numbers in rows and columns."""
    try:
        table = np.asarray(values)
    except ValueError:  # rows of different lengths
        return False
    return table.ndim == 2 and table.dtype.kind in "iuf"
