# SPDX-License-Identifier: MIT
"""Surfaces of a library's shapes, read a few at a time."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import Match
from shapegoogle_core.library.storage.errors import damaged
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import PreparedSample, SurfaceSample, supports

__all__ = ["prepared_matches", "stored_supports", "unpack_sample"]

# So many are read at once: 4 MB.
_AT_ONCE = 256


def prepared_matches(
    store: Store, model: ShapeModel, matches: Sequence[Match]
) -> Iterator[tuple[Match, PreparedSample | None]]:
    """Pair matches with their prepared samples, one at a time to save memory.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        The one that described the shapes.
    matches : sequence of Match

    Yields
    ------
    match, prepared : Match, PreparedSample or None
        None for a shape without a surface, or one that is gone.
    """
    data = store.samples([match.shape_id for match in matches])
    for match in matches:
        content = data.get(match.shape_id)
        sample = None if content is None else unpack_sample(store, model, match.shape_id, content)
        yield match, None if sample is None else PreparedSample(sample)


def stored_supports(
    store: Store, model: ShapeModel, query: PreparedSample, asked: Mapping[int, Collection[int]]
) -> dict[int, NDArray[np.float32]]:
    """Tell by `supports` which shapes may have something in common with a query.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        The one that described the shapes.
    query : PreparedSample
    asked : mapping of int to collection of int
        By the shapes' ids: at which of the query's scales.

    Returns
    -------
    supports : dict of int to (s,) array
        By shape id; shapes without a surface are left out.
    """
    found: dict[int, NDArray[np.float32]] = {}
    shape_ids = list(asked)
    for start in range(0, len(shape_ids), _AT_ONCE):
        data = store.samples(shape_ids[start : start + _AT_ONCE])
        samples = [unpack_sample(store, model, shape_id, content) for shape_id, content in data.items()]
        wanted = np.zeros((len(samples), len(query.scales)), bool)
        for row, shape_id in enumerate(data):
            wanted[row, list(asked[shape_id])] = True
        found |= zip(data, supports(query, samples, wanted), strict=True)
    return found


def unpack_sample(store: Store, model: ShapeModel, shape_id: int, data: bytes) -> SurfaceSample:
    """Rebuild a stored sample; `LibraryError` when it is damaged."""
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
