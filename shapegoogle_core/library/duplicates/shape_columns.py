# SPDX-License-Identifier: MIT
"""Codes, counts and sources of all shapes of a library, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.store import Store, all_codes

__all__ = ["ShapeColumns", "read_columns"]

# Records read at once.
PAGE = 2_000


@dataclass(frozen=True, eq=False)
class ShapeColumns:
    """All shapes of a library, one row for each, in the order of their ids.

    Attributes
    ----------
    shape_ids : (n,) array of int64
    codes : (n, s/8) array of uint8
    vertex_count, face_count : (n,) array of int64
    source_of : (n,) array of int64
        Number of each shape's source in `sources`.
    sources : dict of str to int
        Numbers of the paths.
    """

    shape_ids: NDArray[np.int64]
    codes: NDArray[np.uint8]
    vertex_count: NDArray[np.int64]
    face_count: NDArray[np.int64]
    source_of: NDArray[np.int64]
    sources: dict[str, int]

    def rows_of(self, source: str) -> NDArray[np.int64]:
        """Return the rows of the shapes of a source.

        Parameters
        ----------
        source : str
            Its path.

        Returns
        -------
        rows : (m,) array of int64
            Empty for an unknown source.
        """
        return np.flatnonzero(self.source_of == self.sources.get(source, -1))


def read_columns(store: Store, code_bytes: int) -> ShapeColumns:
    """Read codes, counts and sources of all shapes.

    Parameters
    ----------
    store : Store
    code_bytes : int
        Length of each code.

    Returns
    -------
    columns : ShapeColumns
        Without shapes that another program adds or removes meanwhile.
    """
    shape_ids, codes = all_codes(store, "codes", code_bytes)
    numbers = np.zeros((len(shape_ids), 3), np.int64)  # vertices, faces, source
    known = np.zeros(len(shape_ids), bool)
    sources: dict[str, int] = {}
    last_id = 0
    while page := store.shapes_after(last_id, PAGE):
        last_id = page[-1].shape_id
        rows = np.searchsorted(shape_ids, [record.shape_id for record in page])
        for row, record in zip(rows.tolist(), page, strict=True):
            if row < len(shape_ids) and shape_ids[row] == record.shape_id:
                source = sources.setdefault(record.source, len(sources))
                numbers[row] = record.vertex_count, record.face_count, source
                known[row] = True
    vertices, faces, source_of = numbers[known].T
    return ShapeColumns(shape_ids[known], codes[known], vertices, faces, source_of, sources)
