# SPDX-License-Identifier: MIT
"""A re-ranker: of equally similar shapes, those of the query's size come first."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

import shapegoogle_core as sg
from shapegoogle_core.plugins import Query, Store


class BySize:
    """Raises the distance of shapes by how much larger or smaller than the first example they are.

    Parameters
    ----------
    store : Store
        The library.
    model : ShapeModel
    settings : SearchSettings
    """

    def __init__(self, store: Store, model: sg.ShapeModel, settings: sg.SearchSettings) -> None:
        pass

    def distances(self, query: Query, matches: Sequence[sg.Match]) -> NDArray[np.float64]:
        """Compute what the matches are sorted by.

        Parameters
        ----------
        query : Query
        matches : sequence of Match
            Best first.

        Returns
        -------
        distances : (n,) array
            ≥ 0.
        """
        areas = np.array([match.area for match in matches])
        doublings = np.abs(np.log2(areas / query.examples[0].area)) / 2
        return np.array([match.distance for match in matches]) + 0.1 * doublings
