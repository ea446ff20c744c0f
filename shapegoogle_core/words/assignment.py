# SPDX-License-Identifier: MIT
"""Soft and hard assignment of descriptors to geometric words (paper, section 4, equation 12)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.distance import cdist

from shapegoogle_core.api.arguments import check_number
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["checked_table", "hard_words", "soft_words"]


def checked_table(name: str, values: ArrayLike, rows: int | None = None) -> FloatArray:
    """Convert rows of numbers to an array.

    Parameters
    ----------
    name : str
        Name of the argument.
    values : (n, d) array_like
    rows : int, optional
        n, if it is known.

    Returns
    -------
    table : (n, d) array of float64

    Raises
    ------
    ValueError
        If they are not numbers in rows and columns, or there are more or fewer rows.
    """
    try:
        table = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.ndim != 2:
        raise ValueError(f"{name} must be numbers in rows and columns, one row for each")
    if rows is not None and len(table) != rows:
        raise ValueError(f"{name} must have a row for each of {rows} vertices, not {len(table)} rows")
    return table


def soft_words(descriptors: FloatArray, centers: FloatArray, sigma: float) -> FloatArray:
    """Distribution of each descriptor over the words (paper, equation 12).

    θ_i(x) = c(x) exp(-‖p(x) - p_i‖² / 2σ²), with c(x) such that Σ_i θ_i(x) = 1

    Parameters
    ----------
    descriptors : (n, d) array
        p(x), the descriptor of each vertex.
    centers : (V, d) array
        p_i, the words of a vocabulary.
    sigma : float
        σ > 0, in the unit of the descriptors.

    Returns
    -------
    words : (n, V) array
        θ(x); rows sum to 1. As σ → 0 they become those of `hard_words`.

    Raises
    ------
    ValueError
        If sigma is not positive, or descriptors and words have different lengths.

    See Also
    --------
    Vocabulary : Learn words and σ.
    bag_of_features : Frequencies of words on a shape.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> centers = np.array([[0.0, 0.0], [1.0, 0.0]])
    >>> sg.soft_words(np.array([[0.5, 0.0], [0.0, 0.0]]), centers, sigma=0.5).round(3).tolist()
    [[0.5, 0.5], [0.881, 0.119]]
    """
    check_number("sigma", sigma, positive=True)
    exponents = _squared_distances(descriptors, centers)
    exponents /= -2 * sigma**2
    exponents -= exponents.max(axis=1, keepdims=True)  # or all terms underflow far from all words
    words: FloatArray = np.exp(exponents)
    words /= words.sum(axis=1, keepdims=True)
    return words


def hard_words(descriptors: FloatArray, centers: FloatArray) -> FloatArray:
    """Assign each descriptor to its nearest word (paper, equation 12 as σ → 0).

    Parameters
    ----------
    descriptors : (n, d) array
        p(x), the descriptor of each vertex.
    centers : (V, d) array
        p_i, the words of a vocabulary.

    Returns
    -------
    words : (n, V) array
        θ(x), with a single 1 in each row.

    Raises
    ------
    ValueError
        If descriptors and words have different lengths.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> centers = np.array([[0.0, 0.0], [1.0, 0.0]])
    >>> sg.hard_words(np.array([[0.4, 0.0], [0.9, 0.1]]), centers).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    squared = _squared_distances(descriptors, centers)
    words = np.zeros(squared.shape)
    words[np.arange(len(words)), squared.argmin(axis=1)] = 1.0
    return words


def _squared_distances(descriptors: FloatArray, centers: FloatArray) -> FloatArray:
    """Compute ‖p(x) - p_i‖² after a check that both have the same d, and there is a word."""
    descriptors, centers = checked_table("descriptors", descriptors), checked_table("centers", centers)
    if descriptors.shape[1] != centers.shape[1] or not len(centers):
        raise ValueError(
            f"descriptors of {descriptors.shape[1]} values do not fit {len(centers)} words of "
            f"{centers.shape[1]}; use the descriptor that the words were learnt from"
        )
    return cdist(descriptors, centers, "sqeuclidean")
