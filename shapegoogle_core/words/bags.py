# SPDX-License-Identifier: MIT
"""Bags of geometric words and of pairs of words (paper, sections 4 and 4.1)."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.api.arguments import check_number
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import Spectrum, check_spectrum
from shapegoogle_core.words.assignment import checked_table

__all__ = ["bag_of_features", "spatially_sensitive_bag"]


def bag_of_features(words: FloatArray, mass: FloatArray | None = None) -> FloatArray:
    """Frequencies of the words on a shape (paper, equation 13).

    f(X) = ∫ θ(x) dμ(x), divided by its sum

    Parameters
    ----------
    words : (n, V) array
        θ(x) at every vertex.
    mass : (n,) array, optional
        Area dμ of every vertex. Default: all vertices have the same weight, as in the authors' own scripts.

    Returns
    -------
    bag : (V,) array
        f(X), which sums to 1.

    Raises
    ------
    ValueError
        If there is not one mass for each row of words.

    See Also
    --------
    spatially_sensitive_bag : Frequencies of pairs of words.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> words = np.array([[1.0, 0.0], [0.5, 0.5]])
    >>> sg.bag_of_features(words, mass=np.array([3.0, 1.0])).tolist()
    [0.875, 0.125]
    """
    words = checked_table("words", words)
    if mass is None:
        weights = np.full(len(words), 1 / max(len(words), 1))
    else:
        mass = checked_table("mass", np.reshape(mass, (-1, 1)), len(words))[:, 0]
        weights = mass / mass.sum()
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
        Eigenpairs of the shape.
    time : float
        t ≥ 0 in squared mesh units. Words count as close if they are at a distance of about √t.
    area_weighted : bool
        Whether to weight vertices by their area, as in the equation. Otherwise all have the same weight.

    Returns
    -------
    bag : (V, V) array
        F(X), symmetric, sums to 1. Entries can be slightly negative where the truncated kernel is.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum`, has not one vertex for each row of words, or the time is
        negative.

    See Also
    --------
    bag_of_features : Frequencies of single words.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> spectrum = sg.compute_spectrum((vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    >>> words = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]])
    >>> sg.spatially_sensitive_bag(words, spectrum, time=0.0).round(3).tolist()  # each vertex by itself
    [[0.25, 0.0], [0.0, 0.75]]
    >>> sg.spatially_sensitive_bag(words, spectrum, time=100.0).round(3).tolist()  # all vertices together
    [[0.062, 0.188], [0.188, 0.562]]
    """
    check_spectrum(spectrum)
    check_number("time", time)
    words = checked_table("words", words, len(spectrum.mass))
    weights = spectrum.mass if area_weighted else np.full(len(words), spectrum.area / len(words))
    projected = spectrum.eigenvectors.T @ (weights[:, None] * words)
    bag: FloatArray = projected.T @ (np.exp(-spectrum.eigenvalues * time)[:, None] * projected)
    bag /= bag.sum()
    return bag
