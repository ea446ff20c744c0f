# SPDX-License-Identifier: MIT
"""A candidate stage: shapes with nearly the area of the query, for parts that are never scaled."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

import shapegoogle_core as sg
from shapegoogle_core.plugins import CandidateSettings, Query, Store


class SameArea:
    """Finds the shapes whose area is that of an example, up to 5 %.

    Parameters
    ----------
    store : Store
        The library.
    model : ShapeModel
    settings : CandidateSettings
    """

    def __init__(self, store: Store, model: sg.ShapeModel, settings: CandidateSettings) -> None:
        self._store = store

    def find(self, query: Query, top: int, among: NDArray[np.int64] | None = None) -> Sequence[int]:
        """Find candidates.

        Parameters
        ----------
        query : Query
        top : int
            Number of matches requested.
        among : (m,) array of int64, optional
            Shapes to choose from.

        Returns
        -------
        shape_ids : sequence of int
        """
        found: list[int] = []
        for example in query.examples:
            near = sg.Filter(area=(0.95 * example.area, 1.05 * example.area))
            found += self._store.filtered_ids(near).tolist()
        return found
