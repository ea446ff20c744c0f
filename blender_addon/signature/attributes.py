# SPDX-License-Identifier: GPL-3.0-or-later
"""Write attributes and colours onto the vertices of bpy meshes, and remove them.

All names begin with "sg_": sg_hks, sg_hks_1 …, sg_sihks_0 …, sg_word, sg_weight_<word>, sg_heat,
sg_keypoint, sg_color. Nothing else on a mesh changes, except the active and the rendered colour attribute,
which are restored when the attributes are cleared, and the selection in `select`.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import bmesh
import numpy as np
from numpy.typing import NDArray

from ..scene import mesh_arrays
from .choices import COLOR, FAMILIES
from .layers import Layer

__all__ = [
    "PREFIX",
    "clear",
    "geometry_hash",
    "is_painted",
    "positive_vertices",
    "select",
    "values_of",
    "write",
]

PREFIX = "sg_"
# Custom property that keeps the user's own active and rendered colour attributes while ours is shown; the
# names are empty where there was none.
OWN_COLORS = "shape_google_colors"

_TYPES = {"f": "FLOAT", "i": "INT"}
_FIELDS = {"FLOAT": "value", "INT": "value", "FLOAT_COLOR": "color"}
# The same in a mesh that is being edited.
_EDIT_LAYERS = {"FLOAT": "float", "INT": "int", "FLOAT_COLOR": "float_color"}


def write(data: Any, kind: str, layers: Sequence[Layer], *, color: bool = True, keep: bool = False) -> None:
    """Write attributes on the vertices of a mesh and make its colours the ones that are shown.

    Parameters
    ----------
    data : bpy.types.Mesh
        In edit mode or not.
    kind : str
        A key of `FAMILIES`: attributes of that family which are not among `layers` are removed.
    layers : sequence of Layer
        With as many values as the mesh has vertices.
    color : bool
        Whether to write the colour too.
    keep : bool
        Whether attributes of the other families stay; else they are removed.
    """
    layers = [layer for layer in layers if color or layer.name != COLOR]
    names = {layer.name for layer in layers}
    stale = re.compile(FAMILIES[kind] if keep else "|".join(FAMILIES.values()))
    with _active_kept(data):
        _remove(data, [name for name in _own_names(data) if stale.fullmatch(name) and name not in names])
        if not (color or keep) and COLOR in data.attributes:
            _remove(data, [COLOR])  # it would show the values of a kind that is no longer there
            _restore_colors(data)
        writer = _write_edited if data.is_editmode else _write_layer
        for layer in layers:
            writer(data, layer)
        if COLOR in names:
            _show_color(data)
    data.update_tag()


def clear(data: Any) -> list[str]:
    """Remove all attributes whose names begin with `PREFIX`, and nothing else.

    Parameters
    ----------
    data : bpy.types.Mesh

    Returns
    -------
    names : list of str
        What was removed.
    """
    names = _own_names(data)
    shown = [data.attributes.active_color_name, data.attributes.default_color_name]
    with _active_kept(data):
        _remove(data, names)
        _restore_colors(data, shown)
    data.update_tag()
    return names


def is_painted(data: Any, kind: str) -> bool:
    """Whether a mesh has attributes of a family."""
    return any(re.fullmatch(FAMILIES[kind], name) for name in _own_names(data))


def values_of(data: Any, name: str) -> NDArray[np.generic]:
    """Read an attribute of the vertices.

    Parameters
    ----------
    data : bpy.types.Mesh
        Not in edit mode.
    name : str

    Returns
    -------
    values : (n,) array of float32 or int32, or (n, 4) array of float32

    Raises
    ------
    KeyError
        If there is no such attribute.
    """
    attribute = data.attributes[name]
    width = 4 if attribute.data_type == "FLOAT_COLOR" else 1
    values = np.empty(len(data.vertices) * width, np.int32 if attribute.data_type == "INT" else np.float32)
    attribute.data.foreach_get(_FIELDS[attribute.data_type], values)
    return values.reshape(-1, 4) if width == 4 else values


def positive_vertices(data: Any, name: str) -> NDArray[np.int64]:
    """Find the vertices at which an attribute of ours is more than 0.

    Parameters
    ----------
    data : bpy.types.Mesh
        In edit mode or not.
    name : str
        Of an attribute of numbers.

    Returns
    -------
    indices : (p,) array of int
        Empty if there is no such attribute.
    """
    attribute = data.attributes.get(name)
    if attribute is None or (attribute.data_type, attribute.domain) != ("FLOAT", "POINT"):
        return np.empty(0, np.int64)
    if not data.is_editmode:
        return np.flatnonzero(np.greater(values_of(data, name), 0))
    edited = bmesh.from_edit_mesh(data)
    place = edited.verts.layers.float[name]
    return np.flatnonzero([vertex[place] > 0 for vertex in edited.verts])


def select(data: Any, vertices: Iterable[int]) -> int:
    """Select vertices of a mesh in edit mode with vertex selection, and no others.

    Parameters
    ----------
    data : bpy.types.Mesh
    vertices : iterable of int

    Returns
    -------
    count : int
        How many of them are selected now: hidden ones cannot be.
    """
    edited = bmesh.from_edit_mesh(data)
    edited.select_mode = {"VERT"}
    for part in (edited.faces, edited.edges, edited.verts):
        for element in part:
            element.select_set(False)
    edited.verts.ensure_lookup_table()
    shown = [edited.verts[index] for index in vertices if not edited.verts[index].hide]
    for vertex in shown:
        vertex.select_set(True)
    edited.select_flush_mode()
    bmesh.update_edit_mesh(data, loop_triangles=False, destructive=False)
    return len(shown)


def geometry_hash(item: Any) -> str:
    """Hash of all that the lengths on an object's base mesh depend on.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object that Blender evaluates.

    Returns
    -------
    digest : str
        The same after moving, turning or mirroring the object. Another one for other vertices, other polygons
        or another scale; scales that differ by less than about one millionth may share one.
    """
    if item.mode == "EDIT":
        item.update_from_editmode()
    data = item.data
    coordinates = mesh_arrays.vertex_positions(data).ravel()
    corners = mesh_arrays.corner_vertices(data)
    starts = mesh_arrays.read(data.polygons, "loop_start", 1, np.int32)[:, 0]
    linear = np.array(item.matrix_world, np.float64)[:3, :3]
    metric = linear.T @ linear  # all that lengths on the surface depend on
    largest = float(np.abs(metric).max())
    digest = hashlib.blake2b(digest_size=16)
    for array in (coordinates, corners, starts):
        digest.update(f"{len(array)} ".encode())  # else bytes of one could be taken for those of the next
        digest.update(array.tobytes())
    digest.update(f"{largest:.6g} {np.round(metric / (largest or 1), 6) + 0.0}".encode())
    return digest.hexdigest()


def _own_names(data: Any) -> list[str]:
    return [attribute.name for attribute in data.attributes if attribute.name.startswith(PREFIX)]


def _layer_type(layer: Layer) -> str:
    return "FLOAT_COLOR" if layer.values.ndim == 2 else _TYPES[layer.values.dtype.kind]


def _write_layer(data: Any, layer: Layer) -> None:
    kind = _layer_type(layer)
    attribute = data.attributes.get(layer.name)
    if attribute is not None and (attribute.data_type, attribute.domain) != (kind, "POINT"):
        data.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = data.attributes.new(layer.name, kind, "POINT")
    values = np.ascontiguousarray(layer.values, np.int32 if kind == "INT" else np.float32)
    attribute.data.foreach_set(_FIELDS[kind], values.ravel())


def _write_edited(data: Any, layer: Layer) -> None:
    """Write while the mesh is in edit mode, where its attributes have no values of their own."""
    kind = _layer_type(layer)
    attribute = data.attributes.get(layer.name)
    if attribute is not None and (attribute.data_type, attribute.domain) != (kind, "POINT"):
        _remove(data, [layer.name])
    edited = bmesh.from_edit_mesh(data)
    layers = getattr(edited.verts.layers, _EDIT_LAYERS[kind])
    place = layers.get(layer.name) or layers.new(layer.name)
    for vertex, value in zip(edited.verts, layer.values.tolist(), strict=True):
        vertex[place] = value
    bmesh.update_edit_mesh(data, loop_triangles=False, destructive=False)


def _remove(data: Any, names: Sequence[str]) -> None:
    # Removing one invalidates references to the others, names stay.
    for name in names:
        data.attributes.remove(data.attributes[name])


@contextmanager
def _active_kept(data: Any) -> Iterator[None]:
    """Keep the attribute active that is: Blender goes by its position, where another one may be later."""
    active = data.attributes.active
    name = "" if active is None else active.name
    yield
    if name in data.attributes:
        data.attributes.active = data.attributes[name]


def _show_color(data: Any) -> None:
    """Make our colour the active and the rendered one, and remember which ones were."""
    attributes = data.attributes
    own = [attributes.active_color_name, attributes.default_color_name]
    # One that is ours already says nothing; what was there before it is known from then.
    known = data.get(OWN_COLORS, ["", ""])
    own = [known[place] if name == COLOR else name for place, name in enumerate(own)]
    if any(own):
        data[OWN_COLORS] = own
    attributes.active_color_name = COLOR
    attributes.default_color_name = COLOR


def _restore_colors(data: Any, shown: Sequence[str] = (COLOR, COLOR)) -> None:
    """Make the user's colours the active and the rendered one again, except those chosen since."""
    if OWN_COLORS not in data:
        return
    own = list(data[OWN_COLORS])
    del data[OWN_COLORS]
    present = {attribute.name for attribute in data.color_attributes}
    for name, before, place in zip(shown, own, ("active_color_name", "default_color_name"), strict=True):
        # One that was chosen while ours was there is kept.
        wanted = before if name == COLOR else name
        if wanted in present:
            setattr(data.attributes, place, wanted)
