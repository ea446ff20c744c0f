# SPDX-License-Identifier: MIT
"""`ShapeRows`: what was read of shapes of a library, in memory as rows of arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["ReadRows", "ShapeRows"]

Rows = tuple[NDArray[Any], ...]

ReadRows = Callable[[Sequence[int]], tuple[Sequence[int], Rows]]
"""Reads shapes, each once: the ids of those that are there, and arrays with a row for each of these."""


class ShapeRows:
    """Arrays with a row for each of the shapes that were read last.

    An id is never given twice and a signature never changes, so what is in memory stays right. It may be that
    of a shape that was removed meanwhile.

    Parameters
    ----------
    read : callable
        Reads shapes that are not in memory, see `ReadRows`.
    most : int
        Number of shapes in memory, unless more are asked for at once.

    Examples
    --------
    >>> import numpy as np
    >>> def read(shape_ids):
    ...     print("reads", shape_ids)
    ...     return shape_ids, (np.square(np.array(shape_ids, float)),)
    >>> rows = ShapeRows(read, most=3)
    >>> rows.of([4, 2])[1][0].tolist()
    reads [4, 2]
    [16.0, 4.0]
    >>> rows.of([2, 3])[1][0].tolist()
    reads [3]
    [4.0, 9.0]
    """

    def __init__(self, read: ReadRows, most: int) -> None:
        self._read = read
        self._most = most
        self._places: dict[int, int] = {}
        # With room at the end; the first `len(_places)` rows are used.
        self._roomy: Rows | None = None

    def of(self, shape_ids: Sequence[int]) -> tuple[NDArray[np.int64], Rows]:
        """Return the rows of shapes.

        Parameters
        ----------
        shape_ids : sequence of int

        Returns
        -------
        shape_ids : (n,) array of int64
            In this order, without those that are not in the library.
        rows : tuple of (n, …) arrays
        """
        missing = [shape_id for shape_id in dict.fromkeys(shape_ids) if shape_id not in self._places]
        if len(self._places) + len(missing) > self._most:
            self._places, self._roomy = {}, None
            missing = list(dict.fromkeys(shape_ids))
        if missing:
            self._append(*self._read(missing))
        there = [shape_id for shape_id in shape_ids if shape_id in self._places]
        places = [self._places[shape_id] for shape_id in there]
        return np.array(there, np.int64), tuple(rows[places] for rows in self._arrays)

    @property
    def _arrays(self) -> Rows:
        if self._roomy is None:
            _, self._roomy = self._read([])
        return self._roomy

    def _append(self, shape_ids: Sequence[int], rows: Rows) -> None:
        used = len(self._places)
        count = used + len(shape_ids)
        known = tuple(new[:0] for new in rows) if self._roomy is None else self._roomy
        roomy = known
        if count > len(roomy[0]):
            room = max(count, min(2 * used, self._most))
            roomy = tuple(np.empty((room, *new.shape[1:]), new.dtype) for new in rows)
            for larger, smaller in zip(roomy, known, strict=True):
                larger[:used] = smaller[:used]
            self._roomy = roomy
        for filled, new in zip(roomy, rows, strict=True):
            filled[used:count] = new
        self._places.update(zip(shape_ids, range(used, count), strict=True))
