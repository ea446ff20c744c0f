# SPDX-License-Identifier: MIT
"""Descriptors as distributions over geometric words, soft or hard (paper, section 4, equation 12)."""

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
    centers : (V, d) array
    sigma : float
        σ > 0, in the unit of the descriptors.

    Returns
    -------
    words : (n, V) array
        Rows sum to 1. As σ → 0 they become those of `hard_words`.
    """
    exponents = cdist(descriptors, centers, "sqeuclidean")
    exponents /= -2 * sigma**2
    exponents -= exponents.max(axis=1, keepdims=True)  # far from all words, every term would underflow
    words: FloatArray = np.exp(exponents)
    words /= words.sum(axis=1, keepdims=True)
    return words


def hard_words(descriptors: FloatArray, centers: FloatArray) -> FloatArray:
    """All weight of each descriptor on its nearest word.

    Parameters
    ----------
    descriptors : (n, d) array
    centers : (V, d) array

    Returns
    -------
    words : (n, V) array
        One 1 in each row.
    """
    words = np.zeros((len(descriptors), len(centers)))
    words[np.arange(len(descriptors)), cdist(descriptors, centers, "sqeuclidean").argmin(axis=1)] = 1.0
    return words
