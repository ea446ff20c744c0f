# SPDX-License-Identifier: MIT
"""Meshes of glTF: primitives as triangles or points, with morph targets and the influences of joints."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count as numbers_from
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.connectivity import used_vertices
from shapegoogle_core.mesh.io.file import DamagedError
from shapegoogle_core.mesh.io.gltf.accessors import accessor_count, read_accessor, read_floats
from shapegoogle_core.mesh.io.gltf.container import Document
from shapegoogle_core.mesh.io.gltf.draco import DracoPrimitive
from shapegoogle_core.mesh.io.gltf.extensions import DRACO
from shapegoogle_core.mesh.io.gltf.json_object import JsonObject
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Part", "announced_size", "read_parts"]

_POINTS, _TRIANGLES, _TRIANGLE_STRIP, _TRIANGLE_FAN = 0, 4, 5, 6


@dataclass(frozen=True, eq=False)
class Part:
    """A primitive of a mesh, before it is put in its place.

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array of int
        Empty for points.
    joints : (n, k) array of int
        The joints that move each vertex, as positions in the skin's list; k is 0 without a skin.
    weights : (n, k) array
        Their influences.
    place : str
        Its place in the file, for errors.
    """

    vertices: FloatArray
    faces: NDArray[np.int64]
    joints: NDArray[np.int64]
    weights: FloatArray
    place: str


def announced_size(document: Document, mesh: JsonObject) -> tuple[int, int]:
    """Return the numbers of triangles and points that a mesh announces, without reading them."""
    faces, points = 0, 0
    for primitive in mesh.objects("primitives"):
        mode = primitive.whole("mode", _TRIANGLES)
        if mode > _TRIANGLE_FAN:
            raise DamagedError(f"has the unknown mode {mode} in {primitive.place}")
        attributes = primitive.object("attributes")
        if primitive.has("indices"):
            corners = accessor_count(document, primitive.whole("indices"), primitive)
        elif attributes.has("POSITION"):
            corners = accessor_count(document, attributes.whole("POSITION"), attributes)
        else:
            continue
        if mode == _TRIANGLES:
            faces += corners // 3
        elif mode in (_TRIANGLE_STRIP, _TRIANGLE_FAN):
            faces += max(corners - 2, 0)
        elif mode == _POINTS:
            points += corners
    return faces, points


def read_parts(document: Document, mesh: JsonObject, weights: FloatArray, with_skin: bool) -> list[Part]:
    """Read the triangles and points of a mesh.

    Parameters
    ----------
    document : Document
    mesh : JsonObject
    weights : (t,) array
        Weights of the morph targets; those behind its end are 0.
    with_skin : bool
        Whether the influences of joints are read.

    Returns
    -------
    parts : list of Part
        Lines, and primitives without positions, are left out.

    Raises
    ------
    FormatError
        If the mesh is damaged.
    """
    parts = []
    for primitive in mesh.objects("primitives"):
        mode = primitive.whole("mode", _TRIANGLES)
        if not primitive.object("attributes").has("POSITION"):
            continue  # allowed: an extension would have to say where the vertices are
        if mode in (_POINTS, _TRIANGLES, _TRIANGLE_STRIP, _TRIANGLE_FAN):
            parts.append(_used(_read_part(document, primitive, mode, weights, with_skin)))
    return parts


def _read_part(
    document: Document, primitive: JsonObject, mode: int, weights: FloatArray, with_skin: bool
) -> Part:
    attributes = primitive.object("attributes")
    extension = primitive.object("extensions")
    positions = document.item("accessors", attributes.whole("POSITION"), attributes)
    compressed = None
    if extension.has(DRACO) and not positions.has("bufferView"):
        compressed = DracoPrimitive.decode(document, primitive)
        vertices, faces = compressed.values("POSITION").astype(np.float64), compressed.faces
    else:
        vertices = read_floats(document, attributes.whole("POSITION"), "VEC3", attributes)
        corners = np.arange(len(vertices))
        if primitive.has("indices"):
            indices = read_accessor(document, primitive.whole("indices"), "SCALAR", primitive)[:, 0]
            corners = _checked(indices, len(vertices), primitive)
        if mode == _POINTS:
            vertices = vertices[np.unique(corners)]
        faces = _triangles(corners, mode)
    for target, weight in zip(primitive.objects("targets"), weights.tolist(), strict=False):
        if weight and target.has("POSITION"):
            moves = read_floats(document, target.whole("POSITION"), "VEC3", target)
            vertices = vertices + weight * _as_many(moves, vertices, target.place)
    joints, shares = [], []
    for number in numbers_from():
        if not with_skin or not (attributes.has(f"JOINTS_{number}") and attributes.has(f"WEIGHTS_{number}")):
            break
        if compressed is not None:
            chosen = compressed.values(f"JOINTS_{number}")
            share = compressed.values(f"WEIGHTS_{number}").astype(np.float64)
        else:
            chosen = read_accessor(document, attributes.whole(f"JOINTS_{number}"), "VEC4", attributes)
            share = read_floats(document, attributes.whole(f"WEIGHTS_{number}"), "VEC4", attributes)
        joints.append(_as_many(chosen.astype(np.int64), vertices, primitive.place))
        shares.append(_as_many(share, vertices, primitive.place))
    return Part(
        vertices,
        faces,
        np.concatenate(joints, axis=1) if joints else np.empty((len(vertices), 0), np.int64),
        np.concatenate(shares, axis=1) if shares else np.empty((len(vertices), 0)),
        primitive.place,
    )


def _checked(indices: NDArray[np.integer], vertex_count: int, primitive: JsonObject) -> NDArray[np.int64]:
    if indices.dtype.kind == "f":
        raise DamagedError(f"has fractions as the indices of {primitive.place}")
    corners = indices.astype(np.int64)
    if len(corners) and not 0 <= corners.min() <= corners.max() < vertex_count:
        strange = corners[(corners < 0) | (corners >= vertex_count)][0]
        raise DamagedError(
            f"has a face that names vertex {strange}, counted from 0, of the {vertex_count:,} "
            f"of {primitive.place}"
        )
    return corners


def _as_many(values: NDArray[Any], vertices: FloatArray, place: str) -> NDArray[Any]:
    if len(values) != len(vertices):
        raise DamagedError(f"has {len(values):,} values for {len(vertices):,} vertices in {place}")
    return values


def _triangles(corners: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    """Make triangles of a list of corners; an incomplete one at the end is left out, as in OpenGL."""
    if mode == _TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if mode == _POINTS or len(corners) < 3:
        return np.empty((0, 3), np.int64)
    if mode == _TRIANGLE_FAN:
        return np.stack([corners[1:-1], corners[2:], np.full(len(corners) - 2, corners[0])], axis=1)
    faces: NDArray[np.int64] = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    faces[1::2] = faces[1::2, [0, 2, 1]]
    # Triangles that name a vertex twice join several strips to one.
    first, second, third = faces.T
    different: NDArray[np.bool_] = (first != second) & (second != third) & (third != first)
    return faces[different]


def _used(part: Part) -> Part:
    """Drop the vertices that no face uses: primitives often share the positions of the whole file."""
    if not len(part.faces):
        return part
    used, faces = used_vertices(part.faces, len(part.vertices))
    return Part(
        part.vertices[used], faces.astype(np.int64), part.joints[used], part.weights[used], part.place
    )
