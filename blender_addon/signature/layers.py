# SPDX-License-Identifier: GPL-3.0-or-later
"""Values and colours of each vertex for a painting, computed without Blender."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .choices import COLOR, KEYPOINT, Painting

if TYPE_CHECKING:
    from shapegoogle_core import Spectrum, VertexKeypoints, VertexSpectrum, VertexWords

FloatArray = NDArray[np.float64]

__all__ = [
    "NO_POINT",
    "STRONG_POINT",
    "Layer",
    "linear_rgb",
    "paint_keypoints",
    "paint_spectrum",
    "paint_words",
    "times_of",
]

# Places in the range of times whose values become red, green and blue.
RGB_SCALES = (0.15, 0.4, 0.65)
# Colours span all but the extreme values: else a single sharp tip would leave everything else dark.
QUANTILES = (0.01, 0.99)
NO_WORD = (0.5, 0.5, 0.5)
# Colours of the surface, of weak and of strong keypoints: light, as Blender shades them.
NO_POINT, WEAK_POINT, STRONG_POINT = (0.78, 0.81, 0.86), (1.0, 0.8, 0.2), (1.0, 0.15, 0.1)
# A spot has its full colour up to this share of its radius.
SPOT_CORE = 0.8


@dataclass(frozen=True)
class Layer:
    """One attribute.

    Attributes
    ----------
    name : str
    values : array
        (n,) of float or of int, or (n, 4) for a colour: linear RGB and alpha.
    """

    name: str
    values: NDArray[np.generic]


def times_of(painting: Painting, spectrum: Spectrum) -> list[float]:
    """Find the times at which a painting takes the heat kernel.

    Parameters
    ----------
    painting : Painting
    spectrum : Spectrum

    Returns
    -------
    times : list of float
        In squared mesh units.
    """
    from shapegoogle_core.descriptors import default_times, time_at

    if painting.kind == "RGB":
        return [time_at(spectrum, scale) for scale in RGB_SCALES]
    if painting.kind == "HKS_TIMES":
        return [float(time) for time in default_times(spectrum, painting.count)]
    return [time_at(spectrum, painting.scale) if painting.time is None else painting.time]


def paint_spectrum(painting: Painting, carried: VertexSpectrum, source: int | None = None) -> list[Layer]:
    """Attributes of a painting that is computed from the spectrum.

    Parameters
    ----------
    painting : Painting
        Of any kind but WORDS and KEYPOINTS.
    carried : VertexSpectrum
    source : int, optional
        Vertex from which heat spreads, for the kind HEAT.

    Returns
    -------
    layers : list of Layer
        At loose vertices all values are 0. The last one is the colour.

    Raises
    ------
    MeshError
        If the shape has no such values; the message does not name the shape.
    """
    from shapegoogle_core import MeshError, heat_kernel, heat_kernel_signature, scale_invariant_hks

    spectrum = carried.spectrum
    if painting.kind == "SI_HKS":
        values = scale_invariant_hks(spectrum, frequencies=painting.frequencies)
        names = [f"sg_sihks_{frequency}" for frequency in range(painting.frequencies)]
    elif painting.kind == "HEAT":
        vertex = None if source is None else carried.nearest(source)
        if vertex is None:
            raise MeshError(
                "no vertex of its surface is selected; in edit mode, select the one that heat spreads from"
            )
        values = heat_kernel(spectrum, vertex, times_of(painting, spectrum)[0])[:, None]
        names = ["sg_heat"]
    else:
        values = heat_kernel_signature(spectrum, times_of(painting, spectrum))
        one = painting.kind == "HKS"
        names = ["sg_hks"] if one else [f"sg_hks_{number}" for number in range(1, values.shape[1] + 1)]
    shown = min(max(painting.shown, 1), values.shape[1]) - 1
    # Signatures are positive and differ by factors: a tip keeps several times the heat of a belly.
    seen = values if painting.kind in ("HEAT", "SI_HKS") else _logarithm(values)
    colors = _rgb_of_three(values) if painting.kind == "RGB" else _colors_of_values(seen[:, shown])
    values, colors = carried.carry(values), carried.carry(colors)
    layers = [Layer(name, column) for name, column in zip(names, values.T, strict=True)]
    return [*layers, Layer(COLOR, _with_alpha(colors))]


def paint_words(painting: Painting, words: VertexWords) -> list[Layer]:
    """Attributes of a painting of words.

    Parameters
    ----------
    painting : Painting
        Of the kind WORDS.
    words : VertexWords

    Returns
    -------
    layers : list of Layer
        The word of each vertex (−1 at loose ones), the soft weights of the words that are most frequent on
        the shape, and the colour, which is the same for the same word on every shape.
    """
    from shapegoogle_core.rendering import word_palette

    word = words.heaviest
    frequent = np.sort(np.argsort(-words.bag, kind="stable")[: painting.weights])
    weights = words.weights(frequent)
    palette = np.concatenate([word_palette(len(words.bag)), [NO_WORD]])
    return [
        Layer("sg_word", word.astype(np.int32)),
        *(
            Layer(f"sg_weight_{index}", column)
            for index, column in zip(frequent.tolist(), weights.T, strict=True)
        ),
        Layer(COLOR, _with_alpha(linear_rgb(palette[word]))),
    ]


def paint_keypoints(keypoints: VertexKeypoints) -> list[Layer]:
    """Attributes of a painting of keypoints.

    Parameters
    ----------
    keypoints : VertexKeypoints

    Returns
    -------
    layers : list of Layer
        The response, 0 at all vertices but the keypoints, and the colour: a spot around each of them.
    """
    share = keypoints.strength[:, None]
    spots = (1 - share) * WEAK_POINT + share * STRONG_POINT
    covered = np.clip(keypoints.coverage / (1 - SPOT_CORE), 0, 1)[:, None]
    colors = keypoints.prolongation @ linear_rgb((1 - covered) * NO_POINT + covered * spots)
    return [Layer(KEYPOINT, keypoints.responses), Layer(COLOR, _with_alpha(colors))]


def linear_rgb(srgb: FloatArray) -> FloatArray:
    """Convert sRGB colours to linear ones, as attributes of type FLOAT_COLOR hold them (IEC 61966-2-1).

    Parameters
    ----------
    srgb : array
        In 0…1.

    Returns
    -------
    linear : array
        Of the same shape.
    """
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _logarithm(values: FloatArray) -> FloatArray:
    # A component left out of a truncated spectrum has no heat: it takes the colour of the least there is.
    least = values[values > 0].min() if (values > 0).any() else 1.0
    return np.log(np.maximum(values, least))


def _colors_of_values(values: FloatArray) -> FloatArray:
    from shapegoogle_core.rendering import value_colors

    low, high = np.quantile(values, QUANTILES)
    return linear_rgb(value_colors(values, float(low), float(high)))


def _rgb_of_three(values: FloatArray) -> FloatArray:
    """Stretch three components of the descriptor over red, green and blue (paper, figure 5).

    They are scaled to unit norm at each vertex, as equation 2 has it: as they are, all three are large at the
    same tips, and the picture is grey.
    """
    norms = np.linalg.norm(values, axis=1, keepdims=True)
    descriptor = values / np.where(norms > 0, norms, 1)
    low, high = np.quantile(descriptor, QUANTILES, axis=0)
    return linear_rgb(np.clip((descriptor - low) / np.where(high > low, high - low, 1), 0, 1))


def _with_alpha(colors: FloatArray) -> NDArray[np.float32]:
    return np.column_stack([colors, np.ones(len(colors))]).astype(np.float32)
