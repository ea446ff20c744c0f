# SPDX-License-Identifier: MIT
"""Candidates for the neighbours of stored shapes, by their codes."""

from __future__ import annotations

from shapegoogle_core.library.search.codes.code_index import CodeIndex
from shapegoogle_core.library.search.codes.shape_index import StoredIndex
from shapegoogle_core.library.search.codes.view_index import ViewIndex
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.views import CODE_BYTES

__all__ = ["StoredCandidates"]

# Shapes with the nearest codes of each kind.
_COUNT = 64


class StoredCandidates:
    """Finds the shapes whose codes are nearest to those of a stored shape.

    Parameters
    ----------
    store : Store
    model : ShapeModel
    codes : StoredIndex
        Codes of bags, in memory.
    views : StoredIndex or None
        Codes of views.
    count : int, optional
        Number of shapes by each kind of code.
    """

    def __init__(
        self,
        store: Store,
        model: ShapeModel,
        codes: StoredIndex[CodeIndex],
        views: StoredIndex[ViewIndex] | None,
        count: int = _COUNT,
    ) -> None:
        self._store = store
        self._model = model
        self._codes = codes
        self._views = views
        self._count = count

    def __call__(self, shape_id: int) -> list[int]:
        """Find the candidates of a shape.

        Parameters
        ----------
        shape_id : int

        Returns
        -------
        shape_ids : list of int
            Each once, without those that are gone; the shape itself may be one of them. Empty for an
            unknown shape.
        """
        code_bytes = self._model.code_bits // 8
        by_bags: list[int] = []
        by_views: list[int] = []
        _, codes = self._store.codes("codes", [shape_id], code_bytes)
        if len(codes):
            found = self._store.nearest_codes(codes[0], self._count)
            if found is None:
                found = self._codes.current().nearest(codes[0], self._count)
            by_bags = found.tolist()
        if self._views is not None and self._model.views is not None:
            _, codes = self._store.codes("view_codes", [shape_id], CODE_BYTES)
            if len(codes):
                alternatives = self._model.views.code_alternatives(codes[0])
                by_views = self._views.current().nearest(alternatives, self._count).tolist()
        there, _ = self._store.codes("codes", list(dict.fromkeys([*by_bags, *by_views])), code_bytes)
        # Those removed since their codes were read: next time others take their places.
        known = set(there.tolist())
        if gone := set(by_bags) - known:
            self._codes.discard(gone)
        if self._views is not None and (gone := set(by_views) - known):
            self._views.discard(gone)
        candidates: list[int] = there.tolist()
        return candidates
