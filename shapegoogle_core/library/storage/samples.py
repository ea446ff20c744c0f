# SPDX-License-Identifier: MIT
"""Surface samples as a library stores them."""

from __future__ import annotations

from shapegoogle_core.library.storage.errors import damaged
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import SurfaceSample

__all__ = ["unpack_sample"]


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
        raise damaged(store.name, f"the surface of shape {shape_id} cannot be read: {error}") from error
    settings = model.settings.sample
    if settings is None or (len(sample.points), len(sample.descriptors)) != (
        settings.points,
        settings.keypoints,
    ):
        raise damaged(store.name, f"the surface of shape {shape_id} has another size than its model's")
    return sample
