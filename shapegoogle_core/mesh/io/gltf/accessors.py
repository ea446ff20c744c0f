# SPDX-License-Identifier: MIT
"""Accessors of glTF: arrays of numbers in a buffer, with strides, sparse changes and normalised integers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError
from shapegoogle_core.mesh.io.gltf.container import Document
from shapegoogle_core.mesh.io.gltf.json_object import JsonObject
from shapegoogle_core.mesh.io.gltf.meshopt import decompressed

__all__ = ["accessor_count", "component_type", "normalised", "read_accessor", "read_floats"]

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def accessor_count(document: Document, index: int, owner: JsonObject) -> int:
    """Return the number of elements of an accessor; `DamagedError` if it is out of any range.

    Parameters
    ----------
    document : Document
    index : int
    owner : JsonObject
        The object that names it, for errors.

    Returns
    -------
    count : int
    """
    accessor = document.item("accessors", index, owner)
    count = accessor.whole("count")
    # An accessor without a buffer takes memory for whatever it claims.
    if count > max(3 * document.file.max_faces, 10_000_000):
        raise DamagedError(f"claims {count:,} values in {accessor.place}, a number out of range")
    return count


def read_accessor(document: Document, index: int, kind: str, owner: JsonObject) -> NDArray[Any]:
    """Read an accessor.

    Parameters
    ----------
    document : Document
    index : int
    kind : str
        The type that is expected, such as "VEC3".
    owner : JsonObject
        The object that names it, for errors.

    Returns
    -------
    values : (count, width) array
        Of the type in the file; normalised integers become float64. May be a view of the file.

    Raises
    ------
    FormatError
        If it has another type, or its bytes are not there.
    """
    accessor = document.item("accessors", index, owner)
    count = accessor_count(document, index, owner)
    if accessor.text("type") != kind:
        raise DamagedError(
            f"has the type {accessor.text('type')[:20]!r} in {accessor.place}, where {kind} is expected"
        )
    width, dtype = _WIDTHS[kind], component_type(accessor)
    if accessor.has("bufferView"):
        values = _view_values(document, accessor, (count, width), dtype)
    else:
        values = np.zeros((count, width), dtype)
    if accessor.has("sparse"):
        values = _with_sparse(document, accessor.object("sparse"), values)
    return normalised(values, accessor)


def normalised(values: NDArray[Any], accessor: JsonObject) -> NDArray[Any]:
    """Map integers to −1…1 or 0…1 if an accessor says that they stand for these."""
    if accessor.values.get("normalized") is not True or values.dtype.kind not in "iu":
        return values
    return np.maximum(values / np.float64(np.iinfo(values.dtype).max), -1.0)


def read_floats(document: Document, index: int, kind: str, owner: JsonObject) -> NDArray[np.float64]:
    """Read an accessor as float64; see `read_accessor`."""
    return read_accessor(document, index, kind, owner).astype(np.float64)


def component_type(owner: JsonObject) -> np.dtype[Any]:
    """Return the type of the numbers of an accessor, or of sparse indices."""
    number = owner.whole("componentType")
    if number not in _TYPES:
        raise DamagedError(f"has the unknown component type {number} in {owner.place}")
    return np.dtype(_TYPES[number])


def _view_values(
    document: Document, owner: JsonObject, shape: tuple[int, int], dtype: np.dtype[Any]
) -> NDArray[Any]:
    """Read an array of a buffer view that an object names."""
    view = document.item("bufferViews", owner.whole("bufferView"), owner)
    data = decompressed(document, view)
    if data is None:
        data = document.bytes_of(view)
    (count, width), offset = shape, owner.whole("byteOffset", 0)
    size = width * dtype.itemsize
    stride = view.whole("byteStride", 0) or size
    needed = offset + stride * (count - 1) + size if count else 0
    if needed > len(data):
        raise DamagedError(
            f"needs {needed:,} bytes of {view.place} for {owner.place}, but it has {len(data):,}"
        )
    return np.ndarray(shape, dtype, data, offset if count else 0, (stride, dtype.itemsize))


def _with_sparse(document: Document, sparse: JsonObject, values: NDArray[Any]) -> NDArray[Any]:
    """Replace some elements of an array."""
    count = sparse.whole("count")
    if count > len(values):
        raise DamagedError(f"replaces {count:,} of {len(values):,} values in {sparse.place}")
    places, changes = sparse.object("indices"), sparse.object("values")
    rows = _view_values(document, places, (count, 1), component_type(places))[:, 0]
    if count and not 0 <= rows.min() <= rows.max() < len(values):
        raise DamagedError(f"replaces value {rows.max()} of {len(values):,} in {sparse.place}")
    changed = values.copy()
    changed[rows.astype(np.int64)] = _view_values(document, changes, (count, values.shape[1]), values.dtype)
    return changed
