# SPDX-License-Identifier: MIT
"""Signatures as bytes, for other programs and machines: numbers and arrays only, nothing that is executed.

The text "SGSIG1", the length of a header (uint32, little-endian), the header as JSON, and then all arrays,
little-endian and compressed together by zlib. The header has "values" (numbers and texts of the signature)
and "arrays", a list of [name, type, shape].
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.signatures import check_signature
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import MeshMeasures, SurfaceSample
from shapegoogle_core.views import ShapeViews

__all__ = ["signature_from_bytes", "signature_to_bytes"]

_MAGIC = b"SGSIG1"
_LENGTH = struct.Struct("<I")
_TYPES = {"|u1", "|i1", "<f4", "<f8", "<i4"}
_LONGEST_HEADER = 20_000
# A signature takes some 30 kB, and ten times as much with its surface in full.
_MOST_BYTES = 2**23
_SAMPLE_ARRAYS = tuple(
    field.name for field in fields(SurfaceSample) if field.name not in {"unit", "packed_heat"}
)


def signature_to_bytes(signature: ShapeSignature, *, exact: bool = False) -> bytes:
    """Write a signature.

    Parameters
    ----------
    signature : ShapeSignature
    exact : bool, optional
        Whether to write its sample in full precision and its surface, so that searches and evidence are those
        of the signature itself. Otherwise the sample is rounded as in a library, in a tenth of the room.

    Returns
    -------
    content : bytes

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> from shapegoogle_core.library.storage.signature_file import signature_from_bytes, signature_to_bytes
    >>> model = sg.load_model()
    >>> content = signature_to_bytes(model.describe(trimesh.creation.icosphere()))
    >>> len(content) < 40_000, signature_from_bytes(content, model).face_count
    (True, 1280)
    """
    values: dict[str, Any] = {
        "area": float(signature.area),
        "vertex_count": int(signature.vertex_count),
        "face_count": int(signature.face_count),
        "extents": [float(extent) for extent in signature.extents],
    }
    arrays: dict[str, NDArray[Any]] = {"bags": signature.bags, "code": signature.code}
    if signature.local_code is not None:
        arrays["local_code"] = signature.local_code
    if signature.view_code is not None:
        arrays["view_code"] = signature.view_code
    if signature.views is not None:
        values["views_made_by"] = signature.views.made_by
        arrays["views"] = signature.views.descriptors
    if signature.measures is not None:
        arrays["measures"] = np.frombuffer(signature.measures.to_bytes(), np.uint8)
    if signature.sample is not None and exact:
        values["sample_unit"] = float(signature.sample.unit)
        arrays |= {f"sample.{name}": getattr(signature.sample, name) for name in _SAMPLE_ARRAYS}
        arrays["sample.packed_heat"] = np.frombuffer(signature.sample.packed_heat, np.uint8)
    elif signature.sample is not None:
        arrays["sample"] = np.frombuffer(signature.sample.to_bytes(), np.uint8)
    if signature.surface is not None and exact:
        arrays["surface.vertices"] = signature.surface.vertices
        arrays["surface.faces"] = signature.surface.faces
    little = {name: np.ascontiguousarray(array, _little(array)) for name, array in arrays.items()}
    listed = [[name, array.dtype.str, list(array.shape)] for name, array in little.items()]
    header = json.dumps({"values": values, "arrays": listed}).encode()
    content = zlib.compress(b"".join(array.tobytes() for array in little.values()), 6)
    return _MAGIC + _LENGTH.pack(len(header)) + header + content


def signature_from_bytes(content: bytes, model: ShapeModel, library: str = "the library") -> ShapeSignature:
    """Read a signature, and check that a library can be searched with it.

    Parameters
    ----------
    content : bytes
        From `signature_to_bytes`; anything else is refused.
    model : ShapeModel
        The library's model.
    library : str, optional
        Name of the library in errors.

    Returns
    -------
    signature : ShapeSignature

    Raises
    ------
    ValueError
        If it is not a signature.
    LibraryError
        If another model made it.
    """
    try:
        values, arrays = _parts(content)
        signature = _signature(values, arrays, model)
    except (KeyError, TypeError, OverflowError, RecursionError, zlib.error, LibraryError) as error:
        raise _refused() from error
    except ValueError as error:
        raise _refused() from error
    check_signature(signature, "the signature", model, library)
    return signature


def _refused() -> ValueError:
    return ValueError("this is not a signature that can be searched with; describe the shape again")


def _little(array: NDArray[Any]) -> np.dtype[Any]:
    return array.dtype.newbyteorder("<")


def _parts(content: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Take the content apart; nothing is allocated that it only claims to hold."""
    start = len(_MAGIC) + _LENGTH.size
    if not content.startswith(_MAGIC) or len(content) < start:
        raise ValueError
    (length,) = _LENGTH.unpack(content[len(_MAGIC) : start])
    if length > _LONGEST_HEADER:
        raise ValueError
    header = json.loads(content[start : start + length])
    decompress = zlib.decompressobj()
    data = decompress.decompress(content[start + length :], _MOST_BYTES)
    if not decompress.eof:
        raise ValueError
    arrays = {}
    position = 0
    for name, kind, shape in header["arrays"]:
        if kind not in _TYPES or not all(type(size) is int and size >= 0 for size in shape):
            raise ValueError
        size = np.dtype(kind).itemsize * math.prod(shape)
        if position + size > len(data):
            raise ValueError
        array = np.frombuffer(data[position : position + size], kind).reshape(shape)
        if not np.isfinite(array).all():
            raise ValueError
        arrays[name] = array
        position += size
    if position != len(data):
        raise ValueError
    return header["values"], arrays


def _signature(values: dict[str, Any], arrays: dict[str, NDArray[Any]], model: ShapeModel) -> ShapeSignature:
    area, extents = float(values["area"]), tuple(float(extent) for extent in values["extents"])
    counts = values["vertex_count"], values["face_count"]
    if not (0 <= area < math.inf and len(extents) == 3 and all(0 <= extent < math.inf for extent in extents)):
        raise ValueError
    if not all(type(count) is int and 0 <= count < 2**40 for count in counts):
        raise ValueError
    views = None
    if "views" in arrays:
        made_by, shape = str(values["views_made_by"]), None if model.views is None else model.views.shape
        if model.views is not None and made_by == model.views.identifier and arrays["views"].shape != shape:
            raise ValueError
        views = ShapeViews(_as(arrays["views"], np.int8), made_by)
    surface = None
    if "surface.vertices" in arrays:
        surface = Mesh(arrays["surface.vertices"], arrays["surface.faces"])
    return ShapeSignature(
        bags=_as(arrays["bags"], np.float32),
        code=_as(arrays["code"], np.uint8),
        area=area,
        vertex_count=counts[0],
        face_count=counts[1],
        sample=_sample(values, arrays, model),
        local_code=_as(arrays["local_code"], np.uint8) if "local_code" in arrays else None,
        surface=surface,
        extents=(extents[0], extents[1], extents[2]),
        measures=MeshMeasures.from_bytes(arrays["measures"].tobytes()) if "measures" in arrays else None,
        views=views,
        view_code=_view_code(arrays, views),
    )


def _as(array: NDArray[Any], kind: type[Any]) -> NDArray[Any]:
    if array.dtype != np.dtype(kind):
        raise ValueError
    return array


def _view_code(arrays: dict[str, NDArray[Any]], views: ShapeViews | None) -> NDArray[np.uint8] | None:
    if (views is None) != ("view_code" not in arrays):
        raise ValueError
    return None if views is None else _as(arrays["view_code"], np.uint8)


def _sample(
    values: dict[str, Any], arrays: dict[str, NDArray[Any]], model: ShapeModel
) -> SurfaceSample | None:
    if "sample" in arrays:
        sample = SurfaceSample.from_bytes(arrays["sample"].tobytes())
    elif "sample.points" in arrays:
        unit = float(values["sample_unit"])
        if not 0 < unit < math.inf:
            raise ValueError
        sample = SurfaceSample(
            unit=unit,
            packed_heat=arrays.get("sample.packed_heat", np.empty(0, np.uint8)).tobytes(),
            **{name: arrays[f"sample.{name}"] for name in _SAMPLE_ARRAYS},
        )
        # Writing it in the form of a library checks that its arrays fit each other.
        SurfaceSample.from_bytes(sample.to_bytes())
    else:
        return None
    settings = model.settings.sample
    sizes = len(sample.points), len(sample.descriptors)
    if settings is not None and (sizes[0] > settings.points or sizes[1] > settings.keypoints):
        raise ValueError
    return sample
