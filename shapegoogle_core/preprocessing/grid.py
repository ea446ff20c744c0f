# SPDX-License-Identifier: MIT
"""Regular grids of cubic cells, in which points and vertices are merged."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["cell_numbers", "finest_cell"]

_CELLS_PER_SIDE = 1 << 20  # three coordinates fit into 64 bits


def cell_numbers(position: FloatArray, cell: float) -> NDArray[np.int64]:
    """Give the cells of points in a grid that begins at 0 a number each.

    Parameters
    ----------
    position : (n, 3) array
        Not negative, and less than a million cells in each direction.
    cell : float
        Side of a cell.

    Returns
    -------
    numbers : (n,) array of int
        Equal for points in one cell.
    """
    x, y, z = (position / cell).astype(np.int64).T
    return np.asarray((x * _CELLS_PER_SIDE + y) * _CELLS_PER_SIDE + z)


def finest_cell(longest_side: float, count_at: Callable[[float], int], budget: int, steps: int) -> float:
    """Find about the smallest cells of which no more than a budget are occupied, by bisection.

    Parameters
    ----------
    longest_side : float
        Largest coordinate.
    count_at : callable
        Number of occupied cells by the side of a cell.
    budget : int
        Most occupied cells.
    steps : int
        Number of bisections: the side is found to 2^(1 - steps) of the longest one.

    Returns
    -------
    cell : float
        Side of a cell.
    """
    too_small, cell = 0.0, 2 * longest_side  # the larger holds everything
    for _ in range(steps):
        middle = (too_small + cell) / 2
        if count_at(middle) <= budget:
            cell = middle
        else:
            too_small = middle
    return cell
