# SPDX-License-Identifier: MIT
"""Bags of geometric words and of pairs of words (paper, sections 4 and 4.1)."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import Spectrum

__all__ = ["bag_of_features", "spatially_sensitive_bag"]


def bag_of_features(words: FloatArray, mass: FloatArray | None = None) -> FloatArray:
    """Frequencies of the words on a shape (paper, equation 13).

    f(X) = ∫ θ(x) dμ(x), divided by its sum

    Parameters
    ----------
    words : (n, V) array
        θ(x) at every vertex.
    mass : (n,) array, optional
        Area dμ of every vertex. Left out: all vertices count alike, as in the authors' own scripts.

    Returns
    -------
    bag : (V,) array
        Sums to 1.
    """
    weights = np.full(len(words), 1 / len(words)) if mass is None else mass / mass.sum()
    bag: FloatArray = weights @ words
    bag /= bag.sum()
    return bag


def spatially_sensitive_bag(
    words: FloatArray, spectrum: Spectrum, time: float, *, area_weighted: bool = True
) -> FloatArray:
    """Frequencies of pairs of words that lie close to each other (paper, equations 15 and 16).

    F(X) = ∬ θ(x) θᵀ(y) K_t(x, y) dμ(x) dμ(y), divided by its sum

    The n × n kernel is never formed: with B = ΦᵀAΘ, F = Bᵀ exp(-Λt) B.

    Parameters
    ----------
    words : (n, V) array
        θ(x) at every vertex.
    spectrum : Spectrum
    time : float
        t ≥ 0 in squared mesh units: how far apart "close" is.
    area_weighted : bool
        Weight vertices by their area, as the equation says. Otherwise all count alike.

    Returns
    -------
    bag : (V, V) array
        Symmetric, sums to 1. Entries can be slightly negative where the truncated kernel is.
    """
    weights = spectrum.mass if area_weighted else np.full(len(words), spectrum.area / len(words))
    projected = spectrum.eigenvectors.T @ (weights[:, None] * words)
    bag: FloatArray = projected.T @ (np.exp(-spectrum.eigenvalues * time)[:, None] * projected)
    bag /= bag.sum()
    return bag
