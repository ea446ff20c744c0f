# SPDX-License-Identifier: MIT
"""Surface samples of candidates, read a few at a time."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import Match
from shapegoogle_core.library.storage.signatures import unpack_sample
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import PreparedSample, SurfaceSample, supports

__all__ = ["Surfaces", "candidate_supports", "prepared_candidates", "remembered", "stored_samples"]

# Samples read at once: 4 MB.
_AT_ONCE = 256
# Keypoints for the first, rough support, and the number of shapes compared together.
_FEW, _FEW_AT_ONCE = 32, 64


Surfaces = Callable[[Sequence[int]], Iterator[tuple[int, SurfaceSample]]]
"""Yields the ids and samples of those of some shapes that have one."""


def stored_samples(
    store: Store, model: ShapeModel, shape_ids: Sequence[int]
) -> Iterator[tuple[int, SurfaceSample]]:
    """Read the surface samples of shapes of a library; with a store and a model, they are `Surfaces`.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    shape_ids : sequence of int

    Yields
    ------
    shape_id, sample : int, SurfaceSample
        Of those of the shapes that have one.

    Raises
    ------
    LibraryError
        If a sample is damaged.
    """
    stored = store.samples(shape_ids)
    for shape_id in shape_ids:
        content = stored.get(shape_id)
        if content is not None:
            yield shape_id, unpack_sample(store, model, shape_id, content)


def remembered(surfaces: Surfaces, known: dict[int, SurfaceSample | None]) -> Surfaces:
    """Make surfaces that are read only once.

    Parameters
    ----------
    surfaces : Surfaces
    known : dict of int to SurfaceSample or None
        By shape id; None for a shape without a surface. Filled by reading.

    Returns
    -------
    surfaces : Surfaces
    """

    def read(shape_ids: Sequence[int]) -> Iterator[tuple[int, SurfaceSample]]:
        missing = [shape_id for shape_id in shape_ids if shape_id not in known]
        if missing:
            known.update(dict.fromkeys(missing))
            known.update(surfaces(missing))
        for shape_id in shape_ids:
            sample = known[shape_id]
            if sample is not None:
                yield shape_id, sample

    return read


def prepared_candidates(
    surfaces: Surfaces, matches: Sequence[Match]
) -> Iterator[tuple[Match, PreparedSample | None]]:
    """Pair matches with their prepared samples, one at a time: prepared, a sample takes ten times the room.

    Parameters
    ----------
    surfaces : Surfaces
    matches : sequence of Match

    Yields
    ------
    match, prepared : Match, PreparedSample or None
        In the order of `matches`; None for a shape without a surface, or one that was removed meanwhile.
    """
    samples = dict(surfaces([match.shape_id for match in matches]))
    for match in matches:
        sample = samples.get(match.shape_id)
        yield match, None if sample is None else PreparedSample(sample)


def candidate_supports(
    surfaces: Surfaces,
    query: PreparedSample,
    scales: Mapping[int, Collection[int]],
    *,
    finely: int | None = None,
) -> dict[int, NDArray[np.float32]]:
    """Compute the support in space that shapes have from a query, see `supports`.

    Parameters
    ----------
    surfaces : Surfaces
    query : PreparedSample
    scales : mapping of int to collection of int
        By the ids of the shapes: positions of the query's scales to try.
    finely : int, optional
        Number of pairs of shape and scale whose support is computed, those that have most from a few
        keypoints; all by default.

    Returns
    -------
    supports : dict of int to (s,) array
        By shape id; shapes without a surface are left out. 0 where it was not computed.
    """
    found: dict[int, SurfaceSample] = {}
    rough: list[NDArray[np.float32]] = []
    shape_ids = list(scales)
    for start in range(0, len(shape_ids), _AT_ONCE):
        samples = dict(surfaces(shape_ids[start : start + _AT_ONCE]))
        wanted = np.zeros((len(samples), len(query.scales)), bool)
        for row, shape_id in enumerate(samples):
            wanted[row, list(scales[shape_id])] = True
        found |= samples
        pairs = finely is None or not samples
        rough.append(
            wanted.astype(np.float32)
            if pairs
            else supports(query, list(samples.values()), wanted, keypoints=_FEW, batch_size=_FEW_AT_ONCE)
        )
    if not found:
        return {}
    chosen = np.concatenate(rough)
    least = 0.0
    if finely is not None and finely < np.count_nonzero(chosen):
        least = float(np.partition(chosen.ravel(), -finely)[-finely])
    wanted = (chosen > 0) & (chosen >= least)
    return dict(zip(found, supports(query, list(found.values()), wanted), strict=True))
