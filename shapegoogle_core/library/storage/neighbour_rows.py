# SPDX-License-Identifier: MIT
"""Rows of the table `neighbours`: the nearest shapes of a shape."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.store import Neighbours

__all__ = ["neighbour_rows", "neighbours_from"]

_IDS = np.dtype("<i8")
_DISTANCES = np.dtype("<f4")


def neighbour_rows(neighbours: Mapping[int, Neighbours]) -> Iterator[tuple[int, bytes, bytes]]:
    """Make the rows of the neighbours of shapes.

    Parameters
    ----------
    neighbours : mapping of int to Neighbours

    Yields
    ------
    shape_id : int
        In ascending order.
    ids, distances : bytes
    """
    for shape_id, (ids, distances) in sorted(neighbours.items()):
        yield shape_id, ids.astype(_IDS).tobytes(), distances.astype(_DISTANCES).tobytes()


def neighbours_from(
    rows: Iterable[tuple[int, bytes, bytes]], damaged: Callable[[str], LibraryError]
) -> dict[int, Neighbours]:
    """Rebuild neighbours from the rows of the table.

    Parameters
    ----------
    rows : iterable of (int, bytes, bytes)
        As `neighbour_rows` makes them.
    damaged : callable
        Makes the error for content that contradicts itself.

    Returns
    -------
    neighbours : dict of int to Neighbours

    Raises
    ------
    LibraryError
        If a row is damaged.
    """
    found = {}
    for shape_id, ids, distances in rows:
        if len(ids) % _IDS.itemsize or len(ids) != 2 * len(distances):
            raise damaged(f"the neighbours of shape {shape_id} cannot be read")
        found[shape_id] = (
            np.frombuffer(ids, _IDS).astype(np.int64),
            np.frombuffer(distances, _DISTANCES).astype(np.float32),
        )
    return found
