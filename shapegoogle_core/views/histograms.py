# SPDX-License-Identifier: MIT
"""Gradient histograms of pictures, and how they change when a picture is mirrored."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["BINS", "CELLS", "gradient_histograms", "mirror_orbits"]

Floats = NDArray[np.float32]

CELLS = 8
"""Cells along each side of a picture."""

BINS = 12
"""Directions of gradients, all around: an edge from dark to bright is not one from bright to dark."""


def gradient_histograms(pictures: Floats) -> Floats:
    """Compute histograms of the directions of gradients in 8 × 8 cells, for each channel.

    Parameters
    ----------
    pictures : (n, size, size, C) array of float32
        `size` is a multiple of 8.

    Returns
    -------
    histograms : (n, C · 8 · 8 · 12) array of float32
        Square roots, so that few strong edges do not drown the others; of unit length, or zeros for an even
        picture.
    """
    count, size, _, channels = pictures.shape
    padded = np.zeros((count, size + 2, size + 2, channels), np.float32)
    padded[:, 1:-1, 1:-1] = pictures
    right = padded[:, 1:-1, 2:] - padded[:, 1:-1, :-2]
    up = padded[:, :-2, 1:-1] - padded[:, 2:, 1:-1]
    edges = np.flatnonzero((right != 0) | (up != 0))
    right, up = right.ravel()[edges], up.ravel()[edges]
    strength = np.sqrt(right * right + up * up)
    angle = np.arctan2(up, right) * np.float32(BINS / (2 * np.pi))
    below = np.floor(angle)
    share = angle - below
    first = below.astype(np.int64) % BINS
    rest, channel = np.divmod(edges, channels)
    rest, column = np.divmod(rest, size)
    number, row = np.divmod(rest, size)
    cell = size // CELLS
    base = ((number * channels + channel) * CELLS + row // cell) * CELLS + column // cell
    length = count * channels * CELLS * CELLS * BINS
    sums = np.bincount(base * BINS + first, strength * (1 - share), length)
    sums += np.bincount(base * BINS + (first + 1) % BINS, strength * share, length)
    histograms = np.sqrt(sums.astype(np.float32)).reshape(count, -1)
    norms = np.linalg.norm(histograms, axis=1, keepdims=True)
    return np.asarray(histograms / np.where(norms > 0, norms, 1), np.float32)


def mirror_orbits(signs: tuple[tuple[int, int], ...]) -> NDArray[np.intp]:
    """Find the entries of a histogram that mirroring the picture exchanges.

    Parameters
    ----------
    signs : tuple of (int, int)
        Of each channel: its factor when the picture is mirrored left to right, and upside down; −1 for the
        components of the normal along that direction.

    Returns
    -------
    orbits : (m, 4) array of int
        Each entry of a histogram once. Mirroring left to right exchanges columns 0 with 1 and 2 with 3,
        upside down 0 with 2 and 1 with 3.
    """
    shape = (len(signs), CELLS, CELLS, BINS)
    channel, row, column, angle = np.indices(shape).reshape(4, -1)
    flipped = np.array(signs)[channel] < 0
    # A channel that changes its sign turns its gradients by half a circle.
    half = BINS // 2
    across = np.ravel_multi_index(
        (channel, row, CELLS - 1 - column, (half - angle + half * flipped[:, 0]) % BINS), shape
    )
    over = np.ravel_multi_index(
        (channel, CELLS - 1 - row, column, (-angle + half * flipped[:, 1]) % BINS), shape
    )
    orbits = np.stack([np.arange(len(channel)), across, over, across[over]], axis=1)
    return np.asarray(orbits[(row < CELLS // 2) & (column < CELLS // 2)], np.intp)
