# SPDX-License-Identifier: MIT
"""From a working shape to its bags, with the vocabularies of a model (paper, figure 2 and algorithm 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import MeshError
from shapegoogle_core.keypoints import detect_keypoints
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.settings import DESCRIPTORS, ModelSettings
from shapegoogle_core.model.working_shape import WorkingShape
from shapegoogle_core.spectral import Spectrum
from shapegoogle_core.words import bag_of_features, hard_words, soft_words, spatially_sensitive_bag

__all__ = ["ChannelWords", "FloatBags", "channel_words", "counted_points", "shape_bags"]

FloatBags = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ChannelWords:
    """Vocabulary of one channel.

    Attributes
    ----------
    centers : (V, d) array
        The words, in the unit of the descriptor.
    sigma : float
        Width σ of the soft words, in the same unit (paper, equation 12).
    """

    centers: FloatArray
    sigma: float


def channel_words(
    settings: ModelSettings, channel: int, vocabulary: ChannelWords, shape: WorkingShape
) -> FloatArray:
    """Compute the words at every vertex of a shape in one channel.

    Parameters
    ----------
    settings : ModelSettings
    channel : int
        Index of the channel.
    vocabulary : ChannelWords
        Vocabulary of that channel.
    shape : WorkingShape

    Returns
    -------
    words : (n, V) array
        θ(x), the distribution of each vertex over the words.

    Raises
    ------
    MeshError
        If the descriptor cannot be computed for the shape.
    """
    chosen = settings.channels[channel]
    try:
        descriptors = DESCRIPTORS[chosen.descriptor](shape.mesh, shape.spectrum, **chosen.parameters)
    except MeshError:
        raise
    except ValueError as error:
        # The settings have tried the parameters, so the cause is the shape, e.g. it has no positive
        # eigenvalue.
        raise MeshError(
            f"{shape.mesh.name!r}: the descriptor {chosen.descriptor!r} cannot be computed: {error}"
        ) from error
    if chosen.soft:
        return soft_words(descriptors, vocabulary.centers, vocabulary.sigma)
    return hard_words(descriptors, vocabulary.centers)


def shape_bags(
    settings: ModelSettings, vocabularies: tuple[ChannelWords, ...], shape: WorkingShape
) -> FloatBags:
    """Compute all bags of a shape, side by side, before tf-idf (paper, equations 13 and 16).

    Parameters
    ----------
    settings : ModelSettings
    vocabularies : tuple of ChannelWords
    shape : WorkingShape

    Returns
    -------
    bags : (B,) array of float32
        A bag of pairs of words is its upper triangle, in which entries off the diagonal count for both
        halves. Every bag sums to 1, or its squares do with `settings.square_root`; only nearly, because the
        root of a negative value of a truncated kernel is 0.

    Raises
    ------
    MeshError
        If the descriptor cannot be computed for the shape.
    """
    blocks = []
    for index, (channel, vocabulary) in enumerate(zip(settings.channels, vocabularies, strict=True)):
        words, spectrum = channel_words(settings, index, vocabulary, shape), shape.spectrum
        if channel.detector is not None:
            points = counted_points(shape.mesh, spectrum, channel.detector)
            words, spectrum = words[points], spectrum.at(points)
        upper = np.triu_indices(channel.words)
        for kind in channel.bags:
            if "pairs" in kind:
                pairs = spatially_sensitive_bag(
                    words, spectrum, channel.pair_time, area_weighted=kind == "pairs"
                )
                bag = ((2 - np.eye(channel.words)) * pairs)[upper]
            else:
                bag = bag_of_features(words, spectrum.mass if kind == "area" else None)
            blocks.append(np.sqrt(np.maximum(bag, 0)) if settings.square_root else bag)
    return np.concatenate(blocks).astype(np.float32)


def counted_points(mesh: Mesh, spectrum: Spectrum, detector: str) -> NDArray[np.int64]:
    """Choose the points whose words are counted (paper, algorithm 2, lines 1 to 4).

    Parameters
    ----------
    mesh : Mesh
        See `prepare`.
    spectrum : Spectrum
        Spectrum of that mesh.
    detector : str
        A key of `shapegoogle_core.keypoints.DETECTORS`.

    Returns
    -------
    vertices : (p,) array of int
        Keypoints, X′ of the algorithm, without those on parts that the truncated spectrum leaves out, as no
        heat flows between these. All vertices of a shape without keypoints, such as a sphere.
    """
    points = detect_keypoints(mesh, spectrum, detector).indices
    points = points[spectrum.eigenvectors[points].any(axis=1)]
    return points if len(points) else np.arange(len(mesh.vertices))
