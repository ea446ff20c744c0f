# SPDX-License-Identifier: MIT
"""Index of codes in memory, and keeping it up to date with a library.

Removing a shape needs no bookkeeping here: the search finds out that a shape is gone when it reads its bags,
and discards it then.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.store import CodeKind, Store

__all__ = ["ShapeIndex", "StoredIndex"]


class ShapeIndex(ABC):
    """Codes of shapes by their ids, in blocks of columns: adding codes moves none of the others.

    Parameters
    ----------
    block : int
        Number of shapes in a block.
    """

    def __init__(self, block: int) -> None:
        self._block = block
        self._blocks: list[NDArray[Any]] = []
        # With room at the end; the first `_count` are used.
        self._roomy_ids = np.empty(0, np.int64)
        self._count = 0
        self._gone = np.empty(0, np.intp)

    @property
    def last_id(self) -> int:
        """The greatest id that was added; 0 if there is none."""
        return int(self._roomy_ids[self._count - 1]) if self._count else 0

    @property
    def gone(self) -> int:
        """Number of codes of discarded shapes."""
        return len(self._gone)

    @property
    def _shape_ids(self) -> NDArray[np.int64]:
        """Ids by position."""
        return self._roomy_ids[: self._count]

    def add(self, shape_ids: NDArray[np.int64], codes: NDArray[np.uint8]) -> None:
        """Append codes.

        Parameters
        ----------
        shape_ids : (n,) array of int64
            In ascending order, greater than all before.
        codes : (n, code_bytes) array of uint8
        """
        columns = self._columns(codes)
        start = 0
        while start < len(shape_ids):
            used = (self._count + start) % self._block
            if used == 0:
                self._blocks.append(np.zeros((len(columns), self._block), columns.dtype))
            portion = columns[:, start : start + self._block - used]
            self._blocks[-1][:, used : used + portion.shape[1]] = portion
            start += portion.shape[1]
        count = self._count + len(shape_ids)
        if count > len(self._roomy_ids):
            roomy = np.empty(max(count, len(self._roomy_ids) * 9 // 8), np.int64)
            roomy[: self._count] = self._shape_ids
            self._roomy_ids = roomy
        self._roomy_ids[self._count : count] = shape_ids
        self._count = count

    def discard(self, shape_ids: Collection[int]) -> None:
        """Skip these shapes from now on, because they are gone."""
        positions = np.searchsorted(self._shape_ids, np.fromiter(shape_ids, np.int64))
        self._gone = np.union1d(self._gone, positions)

    def _positions(self, among: NDArray[np.int64]) -> NDArray[np.intp]:
        """Find the positions of shapes, in ascending order, without unknown and discarded ones."""
        known = np.flatnonzero(np.isin(self._shape_ids, among))
        return np.asarray(np.setdiff1d(known, self._gone, assume_unique=True), np.intp)

    def _at(self, positions: NDArray[np.intp]) -> NDArray[Any]:
        """Collect the columns at positions in ascending order."""
        cuts = np.searchsorted(positions, self._block * np.arange(1, len(self._blocks)))
        portions = np.split(positions, cuts) if self._blocks else []
        columns = [
            block[:, portion % self._block] for block, portion in zip(self._blocks, portions, strict=True)
        ]
        return np.concatenate(columns, axis=1) if columns else np.empty((1, 0), np.uint64)

    def _filled(self) -> Iterator[NDArray[Any]]:
        """Iterate over the blocks; of the last one only the part that is used."""
        for index, block in enumerate(self._blocks):
            yield block[:, : self._count - self._block * index]

    @abstractmethod
    def _columns(self, codes: NDArray[np.uint8]) -> NDArray[Any]:
        """Convert codes (n, code_bytes) to columns (rows, n) of a block."""


Index = TypeVar("Index", bound=ShapeIndex)


class StoredIndex(Generic[Index]):
    """Index of one kind of codes: all are read when first used, later only those added since.

    Parameters
    ----------
    store : Store
    kind : {"codes", "local_words", "view_codes"}
    code_bytes : int
        Length of each code.
    empty : callable
        Makes an empty index.
    max_removed : int
        Number of codes of removed shapes that are kept before all codes are read again.
    """

    def __init__(
        self, store: Store, kind: CodeKind, code_bytes: int, empty: Callable[[], Index], max_removed: int
    ) -> None:
        self._store = store
        self._kind = kind
        self._code_bytes = code_bytes
        self._empty = empty
        self._max_removed = max_removed
        self._index: Index | None = None

    def current(self) -> Index:
        """Return the index with all codes, including those of shapes removed by others in the meantime."""
        if self._index is None or self._index.gone > self._max_removed:
            self._index = self._empty()
        for shape_ids, codes in self._store.code_pages(self._kind, self._index.last_id, self._code_bytes):
            self._index.add(shape_ids, codes)
        return self._index

    def discard(self, shape_ids: Collection[int]) -> None:
        """Skip these shapes from now on, because they are gone."""
        if self._index is not None:
            self._index.discard(shape_ids)

    def forget(self) -> None:
        """Read all codes again when they are next used."""
        self._index = None
