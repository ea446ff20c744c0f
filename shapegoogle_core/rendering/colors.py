# SPDX-License-Identifier: MIT
"""Perceptually uniform colours for words and for values.

Colours are compared in OKLab (Ottosson 2020), where equal distances look equally large.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["value_colors", "word_palette"]

FloatArray = NDArray[np.float64]

# OKLab to the cube roots of cone responses, and cone responses to linear sRGB.
_LAB_TO_LMS = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_LMS_TO_RGB = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)

# Grey means that there is no word; the most saturated colours hide the shading.
_SMALLEST_CHROMA, _LARGEST_CHROMA = 0.04, 0.17

# From a dark violet blue over teal to a light yellow: lightness, chroma, hue in degrees (OKLCh).
_VALUE_ANCHORS = np.array(
    [
        [0.27, 0.11, 290],
        [0.42, 0.11, 265],
        [0.55, 0.09, 220],
        [0.68, 0.11, 170],
        [0.80, 0.16, 130],
        [0.93, 0.17, 105],
    ]
)


def _oklab_to_srgb(lab: FloatArray) -> FloatArray:
    """Convert OKLab (…, 3) to sRGB without clipping: colours outside 0…1 cannot be shown."""
    linear = (lab @ _LAB_TO_LMS.T) ** 3 @ _LMS_TO_RGB.T
    magnitude = np.abs(linear)
    encoded = np.where(magnitude <= 0.0031308, 12.92 * magnitude, 1.055 * magnitude ** (1 / 2.4) - 0.055)
    return np.asarray(np.copysign(encoded, linear))


def word_palette(count: int) -> FloatArray:
    """Choose colours for geometric words that differ from each other as much as a screen allows.

    Colours are chosen one by one, each as far as possible from all before it, so that word i has the same
    colour in every palette.

    Parameters
    ----------
    count : int
        Number of words, at least 0.

    Returns
    -------
    colors : (count, 3) array
        sRGB from 0 to 1.

    Raises
    ------
    ValueError
        If the number is negative.

    Examples
    --------
    >>> from shapegoogle_core.rendering import word_palette
    >>> bool((word_palette(3) == word_palette(5)[:3]).all())
    True
    """
    if count < 0:
        raise ValueError(f"a palette has at least 0 colours, not {count}")
    # Only medium lightness, so that shading stays visible and no word looks like the background.
    lightness, a, b = np.meshgrid(
        np.linspace(0.5, 0.88, 12), np.linspace(-0.2, 0.2, 33), np.linspace(-0.2, 0.2, 33), indexing="ij"
    )
    lab = np.stack([lightness, a, b], axis=-1).reshape(-1, 3)
    rgb = _oklab_to_srgb(lab)
    chroma = np.hypot(lab[:, 1], lab[:, 2])
    shown = ((rgb >= 0) & (rgb <= 1)).all(axis=1) & (chroma > _SMALLEST_CHROMA) & (chroma < _LARGEST_CHROMA)
    lab, rgb = lab[shown], rgb[shown]
    chosen = np.empty(count, int)
    # The first colour is a saturated blue, which is easy to see for the most frequent word.
    nearest = np.linalg.norm(lab - [0.6, -0.04, -0.17], axis=1)
    first = int(nearest.argmin())
    distance = np.full(len(lab), np.inf)
    for word in range(count):
        chosen[word] = first if word == 0 else distance.argmax()
        distance = np.minimum(distance, np.linalg.norm(lab - lab[chosen[word]], axis=1))
    return rgb[chosen]


def value_colors(values: ArrayLike, low: float | None = None, high: float | None = None) -> FloatArray:
    """Map values to colours from dark blue over teal to light yellow, with evenly increasing lightness.

    Parameters
    ----------
    values : (n,) array_like
        Finite numbers.
    low, high : float, optional
        Values of the darkest and the lightest colour; by default the smallest and the largest value. Values
        outside get the colour of the nearer end.

    Returns
    -------
    colors : (n, 3) array
        sRGB from 0 to 1. If all values are equal, they get the middle colour.

    Raises
    ------
    ValueError
        If the values are not one number per vertex, or are not finite.

    Examples
    --------
    >>> from shapegoogle_core.rendering import value_colors
    >>> value_colors([0, 5, 10]).round(2)
    array([[0.16, 0.09, 0.34],
           [0.19, 0.59, 0.58],
           [0.98, 0.93, 0.32]])
    """
    numbers = np.asarray(values, float)
    if numbers.ndim != 1:
        raise ValueError(f"values must be one number per vertex, shape (n,), not {numbers.shape}")
    if not np.isfinite(numbers).all():
        raise ValueError(f"{int((~np.isfinite(numbers)).sum())} of {len(numbers)} values are NaN or infinite")
    if len(numbers) == 0:
        return np.empty((0, 3))
    low = float(numbers.min()) if low is None else low
    high = float(numbers.max()) if high is None else high
    place = np.clip((numbers - low) / (high - low), 0, 1) if high > low else np.full(len(numbers), 0.5)
    hue = np.radians(_VALUE_ANCHORS[:, 2])
    anchors = np.stack(
        [_VALUE_ANCHORS[:, 0], _VALUE_ANCHORS[:, 1] * np.cos(hue), _VALUE_ANCHORS[:, 1] * np.sin(hue)], axis=1
    )
    # Space the anchors by their distances, so that colours change evenly with the value.
    steps = np.linalg.norm(np.diff(anchors, axis=0), axis=1)
    stops = np.concatenate([[0], np.cumsum(steps)]) / steps.sum()
    lab = np.stack([np.interp(place, stops, anchors[:, channel]) for channel in range(3)], axis=1)
    return np.clip(_oklab_to_srgb(lab), 0, 1)
