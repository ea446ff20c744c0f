# SPDX-License-Identifier: GPL-3.0-or-later
"""What is painted: the values and colours of each vertex, computed without Blender."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from shapegoogle_core import Spectrum, VertexKeypoints, VertexSpectrum, VertexWords

    FloatArray = NDArray[np.float64]
else:
    from ..lazy_numpy import np

__all__ = [
    "CHANNELS",
    "COLOR",
    "DETECTORS",
    "FAMILIES",
    "KEYPOINT",
    "KINDS",
    "LAPLACIANS",
    "Layer",
    "Painting",
    "linear_rgb",
    "paint_keypoints",
    "paint_spectrum",
    "paint_words",
    "si_hks_exponents",
    "time_at",
    "time_range",
    "times_of",
]

# Identifier, label and tooltip, as Blender's enumerations take them.
KINDS = (
    ("HKS", "Heat Kernel Signature", "How much of its heat a vertex keeps for a time: attribute sg_hks"),
    (
        "HKS_TIMES",
        "HKS at Several Times",
        "Times spread evenly over the range: attributes sg_hks_1, sg_hks_2 …",
    ),
    ("SI_HKS", "Scale-Invariant HKS", "The same at any size: an attribute for each frequency, sg_sihks_0 …"),
    (
        "WORDS",
        "Geometric Words",
        "The word of each vertex, sg_word, and how much it is each of the main words",
    ),
    (
        "RGB",
        "HKS in Red, Green, Blue",
        "Three times, from short to long, as one color: sg_hks_1 to sg_hks_3",
    ),
    ("HEAT", "Heat from a Vertex", "How heat spreads from the active vertex, or the first selected: sg_heat"),
    (
        "KEYPOINTS",
        "Keypoints",
        "Vertices that stand out, and how much: sg_keypoint, 0 at all others. The color shows spots around "
        "them, the redder the stronger",
    ),
)
DETECTORS = (
    ("hks-maxima", "Heat Maxima", "Where heat stays longest: the tips of limbs, also when they are bent"),
    ("mesh-dog", "Differences of Gaussians", "Extrema of the mean curvature over place and scale"),
    ("salient-points", "Salient Points", "Where smoothing moves the surface most along its normal"),
    ("harris-3d", "Harris Corners", "Where the surface is steep in every direction; slow on large meshes"),
)
CHANNELS = (
    ("hks", "HKS", "Words of heat kernel signatures at several times"),
    (
        "log-hks",
        "Logarithmic HKS",
        "Words of the logarithms of heat kernel signatures, which see small parts",
    ),
    ("si-hks", "Scale-Invariant HKS", "Words that do not depend on the size of a part"),
)
LAPLACIANS = (
    (
        "robust",
        "Robust",
        "Intrinsic Delaunay, on two sheets: right for any mesh, also one that is not manifold",
    ),
    ("cotangent", "Cotangent", "Cotangent weights with lumped areas, as in the paper"),
    ("cotangent-voronoi", "Cotangent, Voronoi", "Cotangent weights; a vertex has what is nearest to it"),
    ("fem1", "Finite Elements", "Linear finite elements with the full mass matrix"),
    ("fem2", "Quadratic Elements", "Finite elements with values at the middles of edges too; slower"),
    ("fem3", "Cubic Elements", "Finite elements with two values on each edge and one in each face; slow"),
)

COLOR = "sg_color"
KEYPOINT = "sg_keypoint"
# Names of the attributes that painting a kind anew replaces.
FAMILIES = {
    "HKS": r"sg_hks",
    "HKS_TIMES": r"sg_hks_\d+",
    "SI_HKS": r"sg_sihks_\d+",
    "WORDS": r"sg_word|sg_weight_\d+",
    "RGB": r"sg_hks_\d+",
    "HEAT": r"sg_heat",
    "KEYPOINTS": KEYPOINT,
}

# Beyond these, e^(-λt) is 1e-4 for the last eigenvalue or for all but the first (Sun et al. 2009).
DECAY = 4 * math.log(10)
# Places in the range of times whose values become red, green and blue.
RGB_SCALES = (0.15, 0.4, 0.65)
# Colours span the values but for the extreme ones: a single sharp tip would leave all else dark.
QUANTILES = (0.01, 0.99)
# log2 t of the scale-invariant signature for a shape of area 1, as in the model that is shipped.
SI_HKS_EXPONENTS = (-13.0, 0.0, 0.125)
NO_WORD = (0.5, 0.5, 0.5)
# Of keypoints: the surface, a point that hardly stands out, the strongest. Light, as Blender shades them.
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


@dataclass(frozen=True)
class Painting:
    """What to paint and how.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    scale : float
        0 to 1: where the time lies in the shape's `time_range`, logarithmically.
    time : float, optional
        A time in squared world units in place of `scale`.
    count : int
        How many times.
    frequencies : int
        How many frequencies of the scale-invariant signature.
    shown : int
        Which of several values the colour shows, counted from 1.
    channel : str
        Whose words: one of `CHANNELS`.
    weights : int
        For how many words, the most frequent of the shape, soft weights are written.
    detector : str
        What finds keypoints: one of `DETECTORS`.
    eigenpairs, laplacian, budget
        See `shapegoogle_core.vertex_spectrum`; not used for words.
    """

    kind: str = "HKS"
    scale: float = 0.5
    time: float | None = None
    count: int = 6
    frequencies: int = 6
    shown: int = 1
    channel: str = "hks"
    weights: int = 4
    detector: str = "hks-maxima"
    eigenpairs: int = 100
    laplacian: str = "robust"
    budget: int | None = 20_000


def time_range(spectrum: Spectrum) -> tuple[float, float]:
    """Shortest and longest time that tell vertices apart: 4 ln 10 / λ_k and 4 ln 10 / λ_2.

    Parameters
    ----------
    spectrum : Spectrum

    Returns
    -------
    shortest, longest : float
        In squared mesh units. At shorter ones the truncated spectrum is felt, after longer ones all heat is
        spread evenly.

    Raises
    ------
    MeshError
        If all eigenvalues are 0: there are as many loose parts as eigenpairs.
    """
    from shapegoogle_core import MeshError

    last = float(spectrum.eigenvalues[-1])
    # Of several components each has a 0.
    positive = spectrum.eigenvalues[spectrum.eigenvalues > 1e-8 * last] if last > 0 else np.empty(0)
    if not len(positive):
        count = len(spectrum.eigenvalues)
        raise MeshError(f"has {count} or more loose parts; raise the number of eigenpairs, or separate it")
    return DECAY / last, DECAY / float(positive[0])


def time_at(spectrum: Spectrum, scale: float) -> float:
    """Time at a place in the range of times.

    Parameters
    ----------
    spectrum : Spectrum
    scale : float
        From 0 (shortest) to 1 (longest), logarithmic in between.

    Returns
    -------
    time : float
        In squared mesh units. Heat has then spread over a distance of about its square root.
    """
    shortest, longest = time_range(spectrum)
    return float(shortest * (longest / shortest) ** scale)


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
    if painting.kind == "RGB":
        return [time_at(spectrum, scale) for scale in RGB_SCALES]
    if painting.kind == "HKS_TIMES":
        return [time_at(spectrum, float(scale)) for scale in np.linspace(0, 1, painting.count)]
    return [time_at(spectrum, painting.scale) if painting.time is None else painting.time]


def si_hks_exponents(area: float) -> FloatArray:
    """Exponents of 2 of the times of the scale-invariant signature, for a shape of some area.

    Parameters
    ----------
    area : float
        In squared mesh units.

    Returns
    -------
    exponents : (s,) array
        A shape twice as large has them two higher, so that truncating the spectrum does not tell sizes apart.
    """
    start, end, step = SI_HKS_EXPONENTS
    return math.log2(area) + np.arange(start, end + step / 2, step)


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
        If the shape has no such values; the message completes a sentence that begins with its name.
    """
    from shapegoogle_core import MeshError, heat_kernel, heat_kernel_signature, scale_invariant_hks

    spectrum = carried.spectrum
    if painting.kind == "SI_HKS":
        values = scale_invariant_hks(
            spectrum, tau=si_hks_exponents(spectrum.area), frequencies=painting.frequencies
        )
        names = [f"sg_sihks_{frequency}" for frequency in range(painting.frequencies)]
    elif painting.kind == "HEAT":
        vertex = None if source is None else carried.nearest(source)
        if vertex is None:
            raise MeshError("has no selected vertex on its surface; select the one that heat spreads from")
        values = heat_kernel(spectrum, vertex, times_of(painting, spectrum)[0])[:, None]
        names = ["sg_heat"]
    else:
        values = heat_kernel_signature(spectrum, times_of(painting, spectrum))
        one = painting.kind == "HKS"
        names = ["sg_hks"] if one else [f"sg_hks_{number}" for number in range(1, values.shape[1] + 1)]
    shown = min(max(painting.shown, 1), values.shape[1]) - 1
    # Signatures differ by factors: a tip keeps several times the heat of a belly. All of them are positive.
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
