# SPDX-License-Identifier: MIT
"""Previews: meshes of about a thousand faces in a few kilobytes, to show a shape without its file.

A preview is the text "SGPV", then little-endian: the numbers n of vertices and m of faces (uint32), the up
axis (uint32), the direction towards the viewer of the thumbnail (3 float32), the least and the greatest
coordinates (6 float32); and then, compressed by zlib, the vertices as shares of that box (n × 3 uint16) and
the faces (m × 3 uint16). Without faces it shows points.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh import Mesh, MeshLike, as_mesh
from shapegoogle_core.mesh.connectivity import used_vertices
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.preprocessing.repair import repair
from shapegoogle_core.preprocessing.resampling import simplify, thin
from shapegoogle_core.rendering.views import canonical_view

__all__ = ["Preview", "make_preview", "preview_of_points", "read_preview"]

_MAGIC = b"SGPV"
_HEADER = struct.Struct("<3I3f6f")
# A closed surface has about twice as many faces as vertices.
_VERTICES, _POINTS = 520, 1_500
# A large mesh is first simplified to this number: collapsing its edges to so few vertices at once can end at
# many more, and the grid that is used then loses thin limbs.
_FIRST_VERTICES = 10 * _VERTICES
# Triangles of polygon soup share no vertices, so that it may keep many more faces than vertices to spare.
_MOST_FACES = 2_000
_STEPS = 65_535
_LARGEST_CONTENT = 2**20


@dataclass(frozen=True, eq=False)
class Preview:
    """A preview, read.

    Attributes
    ----------
    mesh : Mesh
        Simplified and rounded; without faces if it shows points.
    up_axis : int
        Axis that points up: 0, 1 or 2.
    toward : (3,) array
        Direction from the shape towards the viewer of its thumbnail.
    """

    mesh: Mesh
    up_axis: int
    toward: NDArray[np.float64]


def make_preview(mesh: MeshLike, up_axis: int | None = None) -> bytes | None:
    """Simplify a shape to about a thousand faces, and write it in a few kilobytes.

    Parameters
    ----------
    mesh : MeshLike
    up_axis : {1, 2}, optional
        Up axis where it is known, see `canonical_view`.

    Returns
    -------
    preview : bytes or None
        None for a mesh without a surface to show.

    Examples
    --------
    >>> import trimesh
    >>> from shapegoogle_core.rendering import make_preview, read_preview
    >>> preview = make_preview(trimesh.creation.icosphere(5))
    >>> mesh = read_preview(preview).mesh
    >>> len(preview) < 15_000, 900 < len(mesh.faces) < 1_100
    (True, True)
    """
    mesh = as_mesh(mesh)
    if mesh.is_point_cloud:
        small = Mesh(thin(mesh.vertices, _POINTS), np.empty((0, 3), np.int32), mesh.name)
    else:
        small = mesh if len(mesh.faces) <= 2 * _VERTICES else _simplified(mesh)
        if len(small.faces) == 0:
            return None
    return _packed(small.vertices, small.faces, canonical_view(small, up_axis))


def preview_of_points(points: NDArray[np.float64]) -> bytes:
    """Write points as a preview, for a shape of which only a sample is known.

    Parameters
    ----------
    points : (n, 3) array

    Returns
    -------
    preview : bytes

    Examples
    --------
    >>> import numpy as np
    >>> from shapegoogle_core.rendering import preview_of_points, read_preview
    >>> points = np.random.default_rng(0).random((100, 3))
    >>> read_preview(preview_of_points(points)).mesh.is_point_cloud
    True
    """
    cloud = Mesh(points, np.empty((0, 3), np.int32))
    return _packed(cloud.vertices, cloud.faces, canonical_view(cloud))


def read_preview(content: bytes) -> Preview:
    """Read a preview.

    Parameters
    ----------
    content : bytes
        From `make_preview`.

    Returns
    -------
    preview : Preview

    Raises
    ------
    ValueError
        If it is not a preview.

    Examples
    --------
    >>> import trimesh
    >>> from shapegoogle_core.rendering import make_preview, read_preview
    >>> read_preview(make_preview(trimesh.creation.box((1, 1, 3)))).up_axis
    2
    """
    start = len(_MAGIC) + _HEADER.size
    if len(content) < start or not content.startswith(_MAGIC):
        raise ValueError("this is not the preview of a shape")
    vertices, faces, up_axis, *figures = _HEADER.unpack(content[len(_MAGIC) : start])
    toward, low, high = (np.array(figures[at : at + 3], np.float64) for at in (0, 3, 6))
    decompressed = zlib.decompressobj()
    try:
        data = decompressed.decompress(content[start:], _LARGEST_CONTENT)
    except zlib.error as error:
        raise ValueError("the preview of a shape is damaged") from error
    if not decompressed.eof or len(data) != 6 * (vertices + faces):
        raise ValueError("the preview of a shape is damaged")
    numbers = np.frombuffer(data, "<u2").reshape(-1, 3)
    mesh = Mesh(low + numbers[:vertices] / _STEPS * (high - low), numbers[vertices:].astype(np.int32))
    return Preview(mesh, int(up_axis), toward)


def _simplified(mesh: Mesh) -> Mesh:
    mesh = repair(mesh)
    if len(mesh.vertices) > 2 * _FIRST_VERTICES:
        mesh = simplify(mesh, _FIRST_VERTICES)
    small = simplify(mesh, _VERTICES)
    if len(small.faces) <= _MOST_FACES:
        return small
    # Of soup the largest triangles show the most.
    largest = small.faces[np.sort(np.argsort(-face_areas(small), kind="stable")[:_MOST_FACES])]
    used, faces = used_vertices(largest.astype(np.int64), len(small.vertices))
    return Mesh(small.vertices[used], faces, mesh.name)


def _packed(vertices: NDArray[np.float64], faces: NDArray[np.int32], view: NDArray[np.float64]) -> bytes:
    low, high = (limit.astype("<f4") for limit in (vertices.min(axis=0), vertices.max(axis=0)))
    extent = np.maximum((high - low).astype(np.float64), np.finfo(np.float32).tiny)
    shares = np.rint((vertices - low) / extent * _STEPS).clip(0, _STEPS).astype("<u2")
    up_axis = int(np.abs(view[1]).argmax())
    header = _HEADER.pack(len(vertices), len(faces), up_axis, *view[2], *low, *high)
    return _MAGIC + header + zlib.compress(shares.tobytes() + faces.astype("<u2").tobytes(), 9)
