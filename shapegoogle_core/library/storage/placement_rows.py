# SPDX-License-Identifier: MIT
"""Rows of the table `placements`: the objects that show a shape."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.placement import Placement

__all__ = ["placement_rows", "placements_from"]

_MATRIX = np.dtype("<f8")


def placement_rows(
    placements: Sequence[Placement], extents: tuple[float, float, float]
) -> Iterator[tuple[Any, ...]]:
    """Make the rows of the placements of a shape, without its id.

    Parameters
    ----------
    placements : sequence of Placement
    extents : (float, float, float)
        Of the first placement; scaled for those that have none of their own.

    Yields
    ------
    row : tuple
        Position, object name, matrix and extents.
    """
    for position, placement in enumerate(placements):
        own = placement.extents
        if own is None:
            factor = placement.scale / placements[0].scale if position else 1.0
            own = (factor * extents[0], factor * extents[1], factor * extents[2])
        matrix = np.ascontiguousarray(placement.matrix, _MATRIX).tobytes()
        yield position, placement.object_name, matrix, *map(float, own)


def placements_from(
    rows: Iterable[tuple[Any, ...]], damaged: Callable[[str], LibraryError]
) -> dict[int, tuple[Placement, ...]]:
    """Rebuild placements from the rows of the table.

    Parameters
    ----------
    rows : iterable of tuple
        Id of the shape, position, object name, matrix and extents.
    damaged : callable
        Makes the error for content that contradicts itself.

    Returns
    -------
    placements : dict of int to tuple of Placement
        By the id of the shape, in the order of positions.

    Raises
    ------
    LibraryError
        If a matrix is damaged.
    """
    found: defaultdict[int, list[tuple[int, Placement]]] = defaultdict(list)
    for shape_id, position, object_name, content, x, y, z in rows:
        if len(content) != 16 * _MATRIX.itemsize:
            raise damaged(f"the place of an object of shape {shape_id} cannot be read")
        matrix = np.frombuffer(content, _MATRIX).reshape(4, 4).astype(np.float64)
        found[shape_id].append((position, Placement(object_name, matrix, (x, y, z))))
    return {
        shape_id: tuple(placement for _, placement in sorted(own, key=lambda pair: pair[0]))
        for shape_id, own in found.items()
    }
