# SPDX-License-Identifier: MIT
"""Which shape stands at which position of an index in memory, and which of them are gone.

Shapes that were removed since they were read need no bookkeeping of changes: the search finds them gone when
it asks for their bags, and has them skipped from then on.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

__all__ = ["ShapeIndex"]


class ShapeIndex(ABC):
    """Codes of shapes by their ids; how they are kept and compared is the subclass's."""

    def __init__(self) -> None:
        # With room at the end; the first `_count` are used.
        self._roomy_ids = np.empty(0, np.int64)
        self._count = 0
        self._gone = np.empty(0, np.intp)

    @property
    def last_id(self) -> int:
        """The greatest id that was added; 0 if none was."""
        return int(self._roomy_ids[self._count - 1]) if self._count else 0

    @property
    def gone(self) -> int:
        """How many codes are kept of shapes that are gone."""
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
        self._add_codes(codes)
        count = self._count + len(shape_ids)
        if count > len(self._roomy_ids):
            roomy = np.empty(max(count, len(self._roomy_ids) * 9 // 8), np.int64)
            roomy[: self._count] = self._shape_ids
            self._roomy_ids = roomy
        self._roomy_ids[self._count : count] = shape_ids
        self._count = count

    def discard(self, shape_ids: Collection[int]) -> None:
        """Skip these shapes from now on; they are gone."""
        positions = np.searchsorted(self._shape_ids, np.fromiter(shape_ids, np.int64))
        self._gone = np.union1d(self._gone, positions)

    @abstractmethod
    def _add_codes(self, codes: NDArray[np.uint8]) -> None:
        """Append codes (n, code_bytes), the first of them at position `_count`."""
