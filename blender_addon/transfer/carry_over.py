# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry vertex groups, colour attributes and UV maps from one mesh to another along a map between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..scene import mesh_arrays
from ..scene.meshes import base_mesh
from ..signature import attributes

if TYPE_CHECKING:
    from shapegoogle_core import Mesh, VertexMatch
    from shapegoogle_core.correspondence import SurfacePoints

FloatArray = NDArray[np.float64]
Indices = NDArray[np.int64]

__all__ = [
    "Layers",
    "Source",
    "Target",
    "Transferred",
    "read_source",
    "read_target",
    "transfer",
    "without_kept",
]

# Smaller weights of a group are left out: interpolation would spread every group over all faces it touches.
LEAST_WEIGHT = 1e-3
# A corner belongs to the same piece of a UV map as the centre of its face if its UV lies where the map goes
# on from there, give or take this share of the way, and this much of the unit square.
SEAM_SHARE, SEAM_LENGTH = 1.0, 0.01


@dataclass(frozen=True, eq=False)
class Layers:
    """Data of a mesh object that can be carried over.

    Attributes
    ----------
    groups : dict of str to (n,) array
        Weights of each vertex group; 0 where a vertex is not in it.
    colors : dict of str to (str, str, array)
        Domain, POINT or CORNER, type and (n or c, 4) values of each colour attribute.
    uvs : dict of str to (c, 2) array
        UV maps, for each corner.
    """

    groups: dict[str, FloatArray] = field(default_factory=dict)
    colors: dict[str, tuple[str, str, FloatArray]] = field(default_factory=dict)
    uvs: dict[str, FloatArray] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.groups or self.colors or self.uvs)


@dataclass(frozen=True, eq=False)
class Source:
    """A mesh object to take from; holds no reference to Blender's data.

    Attributes
    ----------
    mesh : Mesh
        Before modifiers, at world scale.
    loops : (m, 3) array of int
        Which corner of Blender's mesh each corner of a triangle is.
    layers : Layers
    """

    mesh: Mesh
    loops: Indices
    layers: Layers


@dataclass(frozen=True, eq=False)
class Target:
    """A mesh object to give to; holds no reference to Blender's data.

    Attributes
    ----------
    mesh : Mesh
    centers : (p,) array of int
        A triangle of each polygon; its centre tells on which side of a seam the polygon lies.
    corner_vertices, corner_polygons : (c,) arrays of int
        Vertex and polygon of each corner.
    """

    mesh: Mesh
    centers: Indices
    corner_vertices: Indices
    corner_polygons: Indices


@dataclass(eq=False)
class Transferred:
    """Names of the data that was transferred, kept or refused, by their kind."""

    groups: list[str] = field(default_factory=list)
    colors: list[str] = field(default_factory=list)
    uvs: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)  # were there already, or are locked
    refused: list[str] = field(default_factory=list)  # Blender has no room for them

    @property
    def count(self) -> int:
        """Number of layers transferred."""
        return len(self.groups) + len(self.colors) + len(self.uvs)


def read_source(item: Any, name: str, *, groups: bool, colors: bool, uvs: bool) -> Source:
    """Read a mesh object with the data that can be carried over.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object, not in edit mode.
    name : str
        What people know it by.
    groups, colors, uvs : bool
        What to read.

    Returns
    -------
    source : Source

    Raises
    ------
    MeshError
        If a coordinate is not finite.
    """
    mesh, loops = _mesh_and_loops(item, name)
    data = item.data
    layers = Layers()
    if groups:
        layers.groups.update(_group_weights(item))
    if colors:
        for attribute in data.color_attributes:
            if attribute.name.startswith((".", attributes.PREFIX)):
                continue  # painted by the panel Signature, and can be painted again
            values = _read(attribute.data, "color", 4)
            layers.colors[attribute.name] = attribute.domain, attribute.data_type, values
    if uvs:
        for layer in data.uv_layers:
            layers.uvs[layer.name] = _read(data.attributes[layer.name].data, "vector", 2)
    return Source(mesh, loops, layers)


def read_target(item: Any) -> Target:
    """Read the data of a mesh object that a transfer to it needs.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object, not in edit mode.

    Returns
    -------
    target : Target

    Raises
    ------
    MeshError
        If a coordinate is not finite.
    """
    mesh, _ = _mesh_and_loops(item, item.name)
    data = item.data
    polygon = mesh_arrays.read(data.loop_triangles, "polygon_index", 1, np.int32)[:, 0]
    centers = np.unique(polygon, return_index=True)[1]
    sizes = mesh_arrays.read(data.polygons, "loop_total", 1, np.int32)[:, 0]
    polygons = np.repeat(np.arange(len(sizes)), sizes)
    return Target(mesh, centers, mesh_arrays.corner_vertices(data).astype(np.int64), polygons)


def without_kept(item: Any, layers: Layers, *, replace: bool) -> tuple[Layers, list[str]]:
    """Tell what may be written onto an object from what it has already and keeps.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object.
    layers : Layers
    replace : bool
        Whether groups and attributes that the object has already may be overwritten. Locked groups never
        are, nor is an attribute of another kind that has the name.

    Returns
    -------
    wanted : Layers
    kept : list of str
    """
    data = item.data
    locked = {group.name: group.lock_weight for group in item.vertex_groups}
    kept = {
        "groups": {name for name in layers.groups if name in locked and not (replace and not locked[name])},
        "colors": {
            name
            for name in layers.colors
            if name in data.attributes and not (replace and name in data.color_attributes)
        },
        "uvs": {
            name
            for name in layers.uvs
            if name in data.attributes and not (replace and name in data.uv_layers)
        },
    }
    wanted = {
        kind: {name: values for name, values in getattr(layers, kind).items() if name not in names}
        for kind, names in kept.items()
    }
    return Layers(**wanted), [
        name for kind, names in kept.items() for name in getattr(layers, kind) if name in names
    ]


def transfer(
    item: Any,
    source: Source,
    target: Target,
    match: VertexMatch,
    centers: SurfacePoints,
    *,
    replace: bool,
) -> Transferred:
    """Write what a source has onto a mesh object.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object, not in edit mode, as it was when `target` was read from it.
    source : Source
    target : Target
    match : VertexMatch
        Of the target's vertices with the source.
    centers : SurfacePoints
        Of the source, for the centres of the target's polygons.
    replace : bool
        As for `without_kept`.

    Returns
    -------
    transferred : Transferred
    """
    layers, kept = without_kept(item, source.layers, replace=replace)
    done = Transferred(kept=kept)
    placed = match.face >= 0
    corners = source.mesh.faces[match.face].astype(np.int64)  # of loose vertices any: their weights are all 0
    loops = source.loops[match.face]

    def at_vertices(values: FloatArray, places: Indices) -> FloatArray:
        carried: FloatArray = np.einsum("pi,pi...->p...", match.weights, values[places])
        return carried

    for name, weights in layers.groups.items():
        _write_group(item, name, at_vertices(weights, corners), placed)
        done.groups.append(name)
    for name, (domain, kind, values) in layers.colors.items():
        carried = at_vertices(values, corners if domain == "POINT" else loops)
        if domain == "CORNER":
            carried = carried[target.corner_vertices]
        _write_color(item.data, name, domain, kind, carried)
        done.colors.append(name)
    for name, uv in layers.uvs.items():
        written = _write_uv(item.data, name, _corner_uvs(uv, source, target, match, centers))
        (done.uvs if written else done.refused).append(name)
    item.data.update_tag()
    return done


def _mesh_and_loops(item: Any, name: str) -> tuple[Mesh, Indices]:
    mesh = base_mesh(item, name)
    loops = mesh_arrays.read(item.data.loop_triangles, "loops", 3, np.int32)
    if np.linalg.det(np.array(item.matrix_world, np.float64)[:3, :3]) < 0:
        loops = loops[:, ::-1]  # as `base_mesh` turns the faces of a mirrored object
    return mesh, loops.astype(np.int64)


def _read(values: Any, name: str, width: int) -> FloatArray:
    return mesh_arrays.read(values, name, width, np.float32).astype(np.float64)


def _group_weights(item: Any) -> dict[str, FloatArray]:
    count = len(item.data.vertices)
    by_index = {group.index: np.zeros(count) for group in item.vertex_groups}
    for vertex in item.data.vertices:
        for entry in vertex.groups:
            if entry.group in by_index:
                by_index[entry.group][vertex.index] = entry.weight
    return {group.name: by_index[group.index] for group in item.vertex_groups}


def _write_group(item: Any, name: str, weights: FloatArray, placed: NDArray[np.bool_]) -> None:
    group = item.vertex_groups.get(name)
    if group is None:
        group = item.vertex_groups.new(name=name)
    else:
        group.remove(np.flatnonzero(placed).tolist())
    for vertex in np.flatnonzero(placed & (weights >= LEAST_WEIGHT)).tolist():
        group.add([vertex], float(weights[vertex]), "REPLACE")


def _write_color(data: Any, name: str, domain: str, kind: str, values: FloatArray) -> None:
    attribute = data.color_attributes.get(name)
    if attribute is not None and (attribute.domain, attribute.data_type) != (domain, kind):
        data.color_attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = data.color_attributes.new(name, kind, domain)
    attribute.data.foreach_set("color", np.ascontiguousarray(values, np.float32).ravel())


def _write_uv(data: Any, name: str, values: FloatArray) -> bool:
    """Write a UV map; False if Blender, which has eight at most, has no room for it."""
    if name not in data.attributes and data.uv_layers.new(name=name, do_init=False) is None:
        return False
    layer = data.attributes[name]
    layer.data.foreach_set("vector", np.ascontiguousarray(values, np.float32).ravel())
    return True


def _corner_uvs(
    uv: FloatArray, source: Source, target: Target, match: VertexMatch, centers: SurfacePoints
) -> FloatArray:
    """UV of each corner (c, 2), so that no polygon spans a seam.

    At a seam the vertex alone does not tell which of its UVs to take. The centre of the polygon does: its
    UV is sure, and the UV map of the face found there, which is affine, goes on to where the corner is. If
    the UV found at the vertex is not about there, it is on the other side of a seam, and the one that the
    affine map gives is taken.
    """
    mesh, loops = source.mesh, source.loops
    # Where each vertex of the target is on the source, and the UV of the face found there.
    places = np.einsum("pi,pid->pd", match.weights, mesh.vertices[mesh.faces[match.face]])
    direct = np.einsum("pi,pid->pd", match.weights, uv[loops[match.face]])[target.corner_vertices]
    face = centers.face[target.corner_polygons]
    origin = np.einsum("pi,pid->pd", centers.weights, uv[loops[centers.face]])[target.corner_polygons]
    offset = places[target.corner_vertices] - mesh.vertices[mesh.faces[face, 0]]
    sides = mesh.vertices[mesh.faces[face, 1:]] - mesh.vertices[mesh.faces[face, :1]]
    gram = np.einsum("cid,cjd->cij", sides, sides)
    gram += 1e-9 * np.trace(gram, axis1=1, axis2=2)[:, None, None] * np.eye(2)  # faces without area
    products = np.einsum("cid,cd->ci", sides, offset)
    shares = np.linalg.solve(gram, products[:, :, None])[:, :, 0]
    own = uv[loops[face]]
    continued = own[:, 0] + np.einsum("ci,cid->cd", shares, own[:, 1:] - own[:, :1])
    way = np.linalg.norm(continued - origin, axis=1)
    apart = np.linalg.norm(direct - continued, axis=1)
    across: FloatArray = np.where((apart > SEAM_SHARE * way + SEAM_LENGTH)[:, None], continued, direct)
    return across
