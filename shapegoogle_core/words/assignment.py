# SPDX-License-Identifier: MIT
"""Soft and hard assignment of descriptors to geometric words (paper, section 4, equation 12)."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["hard_words", "soft_words"]


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
    exponents = cdist(descriptors, centers, "sqeuclidean")
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

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> centers = np.array([[0.0, 0.0], [1.0, 0.0]])
    >>> sg.hard_words(np.array([[0.4, 0.0], [0.9, 0.1]]), centers).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    words = np.zeros((len(descriptors), len(centers)))
    words[np.arange(len(descriptors)), cdist(descriptors, centers, "sqeuclidean").argmin(axis=1)] = 1.0
    return words
