# SPDX-License-Identifier: MIT
"""Index in memory of one kind of codes of a library."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Generic, TypeVar

from shapegoogle_core.library.search.codes.shape_index import ShapeIndex
from shapegoogle_core.library.storage.store import CodeKind, Store

__all__ = ["StoredIndex"]

Index = TypeVar("Index", bound=ShapeIndex)


class StoredIndex(Generic[Index]):
    """Index of one kind of codes: all are read when first used, later only those added since.

    Parameters
    ----------
    store : Store
    kind : {"codes", "local_words"}
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
