# SPDX-License-Identifier: MIT
"""Signatures on their way into a library, checked and rounded, and back from it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.store import Store, damaged
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import MeshMeasures, SurfaceSample
from shapegoogle_core.views import CODE_BYTES, ShapeViews, packed_size, unpack_descriptors

__all__ = [
    "BAG_TYPE",
    "check_signature",
    "read_signature",
    "round_bags",
    "stored_views",
    "unpack_measures",
    "unpack_sample",
]


BAG_TYPE = np.dtype("<f2")
"""Half floats, little-endian: half the room of float32 and the same rankings (docs/reference/library.md)."""


def round_bags(bags: NDArray[np.float32]) -> NDArray[np.float32]:
    """Round bags to the precision of a library.

    Parameters
    ----------
    bags : array of float32

    Returns
    -------
    rounded : array of float32
        Of the same shape, with 11 significant bits; infinite beyond 65,504.
    """
    with np.errstate(over="ignore"):
        return bags.astype(BAG_TYPE).astype(np.float32)


def check_signature(signature: ShapeSignature, name: str, model: ShapeModel, library: str) -> None:
    """Raise LibraryError if a signature cannot be compared with those of a library.

    Parameters
    ----------
    signature : ShapeSignature
    name : str
        Name of the shape in error messages.
    model : ShapeModel
        The library's model.
    library : str
        Name of the library, see `Store.name`.

    Raises
    ------
    LibraryError
        If another model made it, or its bags are not numbers that the library can hold.
    """
    difference = _difference(model, signature)
    if difference:
        raise LibraryError(
            f"{name!r} was described with another model than that of '{library}' "
            f"({model.identifier}): {difference}; describe it with library.model"
        )
    if not np.isfinite(round_bags(signature.bags)).all():
        raise LibraryError(f"{name!r} has a bag with NaN, infinite or huge entries; describe it again")


def _difference(model: ShapeModel, signature: ShapeSignature) -> str:
    """Return the difference between a signature and those of a model; empty if there is none."""
    if (signature.bags.shape, signature.code.shape) != ((model.bag_size,), (model.code_bits // 8,)):
        return (
            f"{signature.bags.size} bag entries and {8 * signature.code.size} bits instead of "
            f"{model.bag_size} and {model.code_bits}"
        )
    if signature.sample is not None and model.settings.sample is None:
        return "that model takes no surface samples"
    local = model.settings.local
    local_bytes = 0 if local is None else local.words // 8
    if signature.local_code is not None and signature.local_code.size != local_bytes:
        return "its local code does not fit"
    if signature.views is not None and (
        model.views is None or signature.views.made_by != model.views.identifier
    ):
        own = "none" if model.views is None else f"those of {model.views.identifier}"
        return f"its views are those of {signature.views.made_by}, and the model's {own}"
    return ""


def read_signature(store: Store, model: ShapeModel, shape_id: int) -> ShapeSignature | None:
    """Read the signature of a shape.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shape.
    shape_id : int

    Returns
    -------
    signature : ShapeSignature or None
        Its bags are rounded to the precision of a library. None for an unknown shape.

    Raises
    ------
    LibraryError
        If the library is damaged.
    """
    with store.snapshot():
        records = store.shapes([shape_id])
        _, bags = store.bags([shape_id], model.bag_size)
        _, codes = store.codes("codes", [shape_id], model.code_bits // 8)
        samples = store.samples([shape_id])
        local = model.settings.local
        local_bytes = 0 if local is None else local.words // 8
        _, local_codes = store.codes("local_words", [shape_id] if local_bytes else [], local_bytes)
        seen, made_by = ([], "") if model.views is None else ([shape_id], model.views.identifier)
        _, view_codes = store.codes("view_codes", seen, CODE_BYTES)
        _, views = stored_views(store, model, seen)
    if not records:
        return None
    (record,) = records
    if len(codes) == 0 or len(bags) == 0:
        raise LibraryError(
            f"'{store.name}' is damaged: shape {shape_id} ({record.name!r}) has no signature; index "
            f"{record.source or 'it'!r} again with --reread, or forget it"
        )
    return ShapeSignature(
        bags=bags[0],
        code=codes[0],
        area=record.area,
        vertex_count=record.vertex_count,
        face_count=record.face_count,
        sample=unpack_sample(store, model, shape_id, samples[shape_id]) if shape_id in samples else None,
        local_code=local_codes[0] if len(local_codes) else None,
        extents=record.extents,
        measures=unpack_measures(store, [shape_id]).get(shape_id),
        views=ShapeViews(views[0], made_by) if len(views) else None,
        view_code=view_codes[0] if len(view_codes) else None,
    )


def stored_views(
    store: Store, model: ShapeModel, shape_ids: Sequence[int]
) -> tuple[NDArray[np.int64], NDArray[np.int8]]:
    """Read the views of shapes, for `ViewModel.distances`.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    shape_ids : sequence of int

    Returns
    -------
    shape_ids : (n,) array of int64
        Of those that have views, sorted; none if the model has not learnt about pictures.
    views : (n, 2, width) array of int8
    """
    if model.views is None:
        return np.empty(0, np.int64), np.empty((0, 2, 0, 0), np.int8)
    found, content = store.views(shape_ids, packed_size(model.views.shape))
    return np.array(found, np.int64), unpack_descriptors(content, model.views.shape)


def unpack_measures(store: Store, shape_ids: Sequence[int]) -> dict[int, MeshMeasures]:
    """Read the measures of shapes.

    Parameters
    ----------
    store : Store
    shape_ids : sequence of int

    Returns
    -------
    measures : dict of int to MeshMeasures
        By shape id; without shapes that have none, or those of another version of Shape Google.
    """
    stored = store.measures(shape_ids).items()
    found = ((shape_id, MeshMeasures.from_bytes(content)) for shape_id, content in stored)
    return {shape_id: measures for shape_id, measures in found if measures is not None}


def unpack_sample(store: Store, model: ShapeModel, shape_id: int, data: bytes) -> SurfaceSample:
    """Rebuild a stored sample.

    Parameters
    ----------
    store : Store
        Named in errors.
    model : ShapeModel
        Model that described the shape.
    shape_id : int
    data : bytes
        From `Store.samples`.

    Returns
    -------
    sample : SurfaceSample

    Raises
    ------
    LibraryError
        If it is damaged.
    """
    try:
        sample = SurfaceSample.from_bytes(data)
    except ValueError as error:
        raise damaged(store.name, f"the surface of shape {shape_id} cannot be read") from error
    settings = model.settings.sample
    if settings is None or (len(sample.points), len(sample.descriptors)) != (
        settings.points,
        settings.keypoints,
    ):
        raise damaged(store.name, f"the surface of shape {shape_id} has another size than its model's")
    return sample
