# SPDX-License-Identifier: GPL-3.0-or-later
"""Choices of painting: kinds, detectors, words and Laplacians, and the names of the attributes."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "CHANNELS",
    "COLOR",
    "DETECTORS",
    "FAMILIES",
    "KEYPOINT",
    "KINDS",
    "LAPLACIANS",
    "TIMED",
    "Painting",
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
    ("mesh-dog", "Mesh DoG", "Extrema of the mean curvature over place and scale"),
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
    (
        "cotangent-voronoi",
        "Cotangent, Voronoi",
        "Cotangent weights; the area of a vertex is that nearest to it",
    ),
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
# Kinds whose colour follows the time slider.
TIMED = ("HKS", "HEAT")
# Kinds with several values, any of which the colour can show without a new computation.
SEVERAL = ("HKS_TIMES", "SI_HKS")


@dataclass(frozen=True)
class Painting:
    """Settings of a painting.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    scale : float
        0 to 1: where the time lies in the shape's `time_range`, logarithmically.
    time : float, optional
        A time in squared world units in place of `scale`.
    count : int
        Number of times.
    frequencies : int
        Number of frequencies of the scale-invariant signature.
    shown : int
        Number of the value that the colour shows, counted from 1.
    channel : str
        Whose words: one of `CHANNELS`.
    weights : int
        Number of words, the most frequent of the shape, whose soft weights are written.
    detector : str
        Detector of keypoints: one of `DETECTORS`.
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
