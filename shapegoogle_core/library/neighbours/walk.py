# SPDX-License-Identifier: MIT
r"""Ordering by a random walk over a neighbour graph.

Two shapes of a kind may be far from each other and still be joined by a chain of neighbours, each near to the
next. A walker that starts at the query, follows a link with a probability that grows with the agreement of
its two ends, and stops at every step with probability 1 - α, visits the shapes of the query's kind often and
others rarely. With the symmetric weights

    A_ij = exp(-d_ij² / (s_i s_j)),    W = D^(-1/2) A D^(-1/2),    D_ii = Σ_j A_ij,

the visits are v = Σ_t (α W)^t e_q = (1 - α W)⁻¹ e_q (Zhou et al. 2004, Ranking on data manifolds; the
self-tuning scale s_i, the distance of the k-th neighbour of i, is from Zelnik-Manor and Perona 2004).

Exact copies are linked as well, but do not count as one of the k neighbours: the walk must be able to leave
a shape that is in the library many times.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from shapegoogle_core.library.search.settings import WalkSettings
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["COPY_DISTANCE", "link_weights", "links_of", "links_of_all", "visits", "walked_distances"]

COPY_DISTANCE = 1e-6
"""Largest distance of a copy: distances are rounded to this."""


def links_of(distances: ArrayLike, settings: WalkSettings) -> NDArray[np.int64]:
    """Choose the shapes that one shape is linked with.

    Parameters
    ----------
    distances : (n,) array_like
        From the shape to others, itself left out.
    settings : WalkSettings

    Returns
    -------
    positions : (l,) array of int64
        The nearest copies, then the nearest others, each by distance and at equal distances by position.

    Examples
    --------
    >>> links_of([0.5, 0, 0.2, 0, 0, 0.1, 0.4], WalkSettings(links=2, copies=2)).tolist()
    [1, 3, 5, 2]
    """
    away = np.asarray(distances, float)
    order = np.argsort(away, kind="stable")
    is_copy = away[order] <= COPY_DISTANCE
    return np.concatenate([order[is_copy][: settings.copies], order[~is_copy][: settings.links]])


def links_of_all(owners: ArrayLike, distances: ArrayLike, settings: WalkSettings) -> NDArray[np.int64]:
    """Choose the shapes that several shapes are linked with, as `links_of` does for one.

    Parameters
    ----------
    owners : (n,) array_like of int
        Number of the shape that each distance is from.
    distances : (n,) array_like
    settings : WalkSettings

    Returns
    -------
    positions : (l,) array of int64
        Those of each shape in the order of `links_of`.

    Examples
    --------
    >>> owners, distances = [7, 7, 7, 3, 3], [0.5, 0, 0.2, 0.1, 0.4]
    >>> links_of_all(owners, distances, WalkSettings(links=1, copies=2)).tolist()
    [3, 1, 2]
    """
    owners, away = np.asarray(owners, np.int64), np.asarray(distances, float)
    order = np.lexsort((away, owners))
    is_copy = away[order] <= COPY_DISTANCE
    numbers = np.arange(len(order))
    is_first = np.diff(owners[order], prepend=owners.min(initial=0) - 1) != 0
    first = np.maximum.accumulate(np.where(is_first, numbers, 0))
    copies: NDArray[np.int64] = np.cumsum(is_copy) - is_copy  # before each place
    rank = np.where(is_copy, numbers - first, numbers - first - (copies - copies[first]))
    return order[rank < np.where(is_copy, settings.copies, settings.links)]


def link_weights(links: ArrayLike, ends: ArrayLike, distances: ArrayLike, count: int) -> sparse.csr_array:
    """Compute the normalised weights W of links.

    Parameters
    ----------
    links, ends : (l,) array_like of int
        Numbers of the shapes at the two ends of each link; the first one has chosen the second.
    distances : (l,) array_like
        Between them; ≥ 0.
    count : int
        Number of shapes.

    Returns
    -------
    weights : (count, count) sparse array
        Symmetric: a link counts if one of its two ends has chosen the other.
    """
    first, second = np.asarray(links, np.int64), np.asarray(ends, np.int64)
    away = np.asarray(distances, float)
    # A shape that has only copies takes the scale of the shapes that have chosen it: nothing is divided by 0.
    scale = np.zeros(count)
    np.maximum.at(scale, first, away)
    lonely = scale == 0
    np.maximum.at(scale, second, np.where(lonely[second], away, 0))
    scale[scale == 0] = 1
    agreement = np.exp(-(away**2) / (scale[first] * scale[second]))
    matrix = sparse.coo_array((agreement, (first, second)), shape=(count, count)).tocsr()
    matrix = matrix.maximum(matrix.T)
    degrees = np.asarray(matrix.sum(axis=1)).ravel()
    inverse = sparse.diags_array(np.where(degrees > 0, degrees, 1.0) ** -0.5)
    return sparse.csr_array(inverse @ matrix @ inverse)


def visits(weights: sparse.csr_array, start: int, damping: float) -> FloatArray:
    """Compute how often a walk from a shape visits each shape.

    Parameters
    ----------
    weights : (n, n) sparse array
        From `link_weights`.
    start : int
        Number of the shape where the walk starts.
    damping : float
        α, from 0 to 1 (excluded).

    Returns
    -------
    visits : (n,) array
        ≥ 0; 0 for shapes that no chain of links joins with the start.
    """
    steps = int(np.ceil(np.log(_NEGLIGIBLE) / np.log(damping))) if damping > 0 else 0
    here = np.zeros(weights.shape[0])
    here[start] = 1
    total = here.copy()
    for _ in range(steps):
        here = damping * (weights @ here)
        total += here
    return total


_NEGLIGIBLE = 1e-3
"""Weight of a step after which the walk ends."""


def walked_distances(distances: ArrayLike, visited: ArrayLike, settings: WalkSettings) -> FloatArray:
    """Lower the distances of matches that a walk from the query visits.

    The distance d of a match with v visits becomes f + (d - f) exp(-g v / max v), where f is the distance of
    the last of the first few matches, and g `settings.gain`.

    Parameters
    ----------
    distances : (n,) array_like
        From the query, in ascending order.
    visited : (n,) array_like
        How often each match was visited.
    settings : WalkSettings

    Returns
    -------
    distances : (n,) array
        Those of the first few, of copies, and of matches that are not visited do not change.

    Examples
    --------
    A far shape that is often visited comes before a nearer one that is not:

    >>> settings = WalkSettings(unchanged=1)
    >>> walked_distances([0.1, 0.2, 0.5, 0.6], [0.9, 0.4, 0, 0.4], settings).round(2).tolist()
    [0.1, 0.1, 0.5, 0.12]
    """
    away, visited = np.array(distances, float), np.asarray(visited, float)
    first = max(settings.unchanged, int((away <= COPY_DISTANCE).sum()))
    most = visited[first:].max(initial=0)
    if most > 0:
        least = away[first - 1] if first else 0.0
        away[first:] = least + (away[first:] - least) * np.exp(-settings.gain * visited[first:] / most)
    return away
