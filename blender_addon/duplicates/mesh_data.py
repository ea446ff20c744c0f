# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of Blender with all their data, and the data in which two congruent meshes differ."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.mesh_arrays import corner_vertices, edge_vertices, polygon_sizes, read, vertex_positions
from ..signature import attributes
from ..time_slices import aside
from ..translation import tr
from .congruence import LARGE, Congruence, PolygonMesh
from .materials import Materials

Indices = NDArray[np.int64]

__all__ = ["WorldMesh", "differing_steps", "world_mesh"]

# Relative or absolute difference up to which two numbers are the same.
CLOSE = 1e-4
# Of normals, unit vectors that Blender keeps with 15 bits, through a rotation with its own error.
CLOSE_NORMALS = 1e-2
# Names of an attribute's values, by the kind of attribute.
VALUES = ("value", "vector", "color")
# Attributes of Blender that mean the same absent as all zero.
ZERO_BY_DEFAULT = {
    "bevel_weight_edge",
    "bevel_weight_vert",
    "crease_edge",
    "crease_vert",
    "material_index",
    "sharp_edge",
    "sharp_face",
}
# Compared as geometry, or by what they mean.
SKIPPED = {"position", "custom_normal"}


@dataclass(frozen=True, eq=False)
class WorldMesh:
    """A mesh as it stands in the world.

    Attributes
    ----------
    data : bpy.types.Mesh
    matrix : (4, 4) array
        From the mesh to the world.
    polygons : PolygonMesh
        In world space. Where the matrix mirrors, the corners of each polygon are taken backwards, as Blender
        shows them.
    corner_ids : (c,) array of int64
        Which loop of `data` each corner is.
    group_names : tuple of str
        Its vertex groups, which only objects show.
    """

    data: Any
    matrix: NDArray[np.float64]
    polygons: PolygonMesh
    corner_ids: Indices
    group_names: tuple[str, ...]


def world_mesh(item: Any) -> WorldMesh | None:
    """Read the mesh of an object before its modifiers.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object; in edit mode as it is edited.

    Returns
    -------
    mesh : WorldMesh or None
        None if it has no vertices, a coordinate is not finite, or the object is scaled to nothing along
        an axis.
    """
    if item.mode == "EDIT":
        item.update_from_editmode()
    data = item.data
    matrix = np.array(item.matrix_world, np.float64)
    points = vertex_positions(data).astype(np.float64)
    # Not `@`: the threads of BLAS wait for each other on a busy machine, and the window for them.
    vertices = np.einsum("nj,ij->ni", points, matrix[:3, :3]) + matrix[:3, 3]
    scales = np.linalg.svd(matrix[:3, :3], compute_uv=False) if np.isfinite(matrix).all() else np.zeros(3)
    if not len(points) or not np.isfinite(vertices).all() or scales[2] <= 1e-9 * scales[0]:
        return None
    corners = corner_vertices(data).astype(np.int64)
    sizes = polygon_sizes(data).astype(np.int64)
    edges = edge_vertices(data).astype(np.int64)
    corner_ids = np.arange(len(corners))
    if np.linalg.det(matrix[:3, :3]) < 0:
        starts = np.repeat(np.cumsum(sizes) - sizes, sizes)
        corner_ids = 2 * starts + np.repeat(sizes, sizes) - 1 - corner_ids
    polygons = PolygonMesh(vertices, corners[corner_ids], sizes, edges)
    return WorldMesh(data, matrix, polygons, corner_ids, tuple(group.name for group in item.vertex_groups))


def differing_steps(
    first: WorldMesh, second: WorldMesh, congruence: Congruence, materials: Materials
) -> Generator[bool, None, list[str]]:
    """Name the data in which two congruent meshes differ, besides the order of their vertices.

    Parameters
    ----------
    first, second : WorldMesh
    congruence : Congruence
        Of their polygons.
    materials : Materials
        Of the file, as long as nothing changes them.

    Yields
    ------
    alone : bool
        True: only with large meshes is there a step, which takes long by itself; see
        `..time_slices.next_slice`.

    Returns
    -------
    names : list of str
        For people: "materials", "UV map 'UVMap'", …; empty when one mesh can stand for the other.
    """
    corners = np.empty(len(first.corner_ids), np.int64)
    corners[first.corner_ids] = second.corner_ids[congruence.corner_order]
    orders = {
        "POINT": congruence.vertex_order,
        "EDGE": congruence.edge_order,
        "FACE": congruence.polygon_order,
        "CORNER": corners,
    }
    one, two = first.data, second.data
    checks: list[tuple[str, Callable[[], bool]]] = [
        (tr("materials"), lambda: materials.are_same(list(one.materials), list(two.materials))),
        (tr("seams"), lambda: _same_seams(one, two, orders["EDGE"])),
        (tr("vertex groups"), lambda: _same_groups(first, second, orders["POINT"])),
        (tr("custom normals"), lambda: _same_normals(first, second, congruence, corners)),
        (tr("custom properties"), lambda: _properties(one) == _properties(two)),
    ]
    is_large = len(corners) >= LARGE
    names = []
    for name, same in checks:
        if not same():
            names.append(name)
        if is_large:
            yield True
    names += yield from _differing_attributes(one, two, orders)
    return names


def _same_seams(one: Any, two: Any, order: Indices) -> bool:
    seams = [read(data.edges, "use_seam", 1, bool).ravel() for data in (one, two)]
    return bool((seams[0] == seams[1][order]).all())


def _same_groups(first: WorldMesh, second: WorldMesh, order: Indices) -> bool:
    if first.group_names != second.group_names:
        return False
    if not first.group_names:
        return True
    weights = [
        [
            sorted((entry.group, round(entry.weight, 4)) for entry in vertex.groups)
            for vertex in each.data.vertices
        ]
        for each in (first, second)
    ]
    return all(own == weights[1][other] for own, other in zip(weights[0], order.tolist(), strict=True))


def _same_normals(first: WorldMesh, second: WorldMesh, congruence: Congruence, corners: Indices) -> bool:
    one, two = first.data, second.data
    if one.has_custom_normals != two.has_custom_normals:
        return False
    if not one.has_custom_normals:
        return True
    normals = []
    turn = congruence.matrix[:3, :3] @ first.matrix[:3, :3], second.matrix[:3, :3]
    for data, linear in zip((one, two), turn, strict=True):
        placed = read(data.corner_normals, "vector", 3, np.float32) @ np.linalg.inv(linear)
        normals.append(placed / np.maximum(np.linalg.norm(placed, axis=1, keepdims=True), 1e-12))
    return bool(np.abs(normals[0] - normals[1][corners]).max(initial=0) <= CLOSE_NORMALS)


def _properties(data: Any) -> dict[str, Any]:
    own = attributes.OWN_COLORS
    values = {key: data[key] for key in data.keys() if key != own}  # noqa: SIM118 (a mesh is not iterable)
    return {
        key: next((getattr(value, how)() for how in ("to_dict", "to_list") if hasattr(value, how)), value)
        for key, value in values.items()
    }


def _differing_attributes(one: Any, two: Any, orders: dict[str, Indices]) -> Generator[bool, None, list[str]]:
    uv_maps = {layer.name for data in (one, two) for layer in data.uv_layers}
    kept = [
        {
            entry.name: entry
            for entry in data.attributes
            # What the panel Signature painted can be painted again.
            if entry.name not in SKIPPED and not entry.name.startswith((".", attributes.PREFIX))
        }
        for data in (one, two)
    ]
    names = []
    is_large = len(orders["CORNER"]) >= LARGE
    for name in sorted(kept[0].keys() | kept[1].keys()):
        if is_large:
            yield True
        first, second = kept[0].get(name), kept[1].get(name)
        if first is None or second is None:
            present = first or second
            if name in ZERO_BY_DEFAULT and not _values(present).any():
                continue
        elif (first.domain, first.data_type) == (second.domain, second.data_type):
            order = orders.get(first.domain)
            if order is not None:
                compare = partial(_close, _values(first), _values(second), order)
                same = (yield from aside(compare)) if is_large else compare()
                if same:
                    continue
        text = tr("UV map {name!r}") if name in uv_maps else tr("attribute {name!r}")
        names.append(text.format(name=name))
    return names


def _values(attribute: Any) -> NDArray[Any]:
    """(n, width) values of an attribute of any kind."""
    if not len(attribute.data):
        return np.empty((0, 1))
    properties = attribute.data[0].bl_rna.properties
    name = next(name for name in VALUES if name in properties)
    if properties[name].type == "STRING":
        return np.array([[entry.value] for entry in attribute.data])
    dtype = {"BOOLEAN": bool, "INT": np.int32}.get(properties[name].type, np.float32)
    return read(attribute.data, name, max(1, properties[name].array_length), dtype)


def _close(one: NDArray[Any], two: NDArray[Any], order: Indices) -> bool:
    two = two[order]
    if one.dtype.kind == "f":
        return bool(np.allclose(one, two, rtol=CLOSE, atol=CLOSE, equal_nan=True))
    return bool(np.array_equal(one, two))
