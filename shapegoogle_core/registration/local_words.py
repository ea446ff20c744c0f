# SPDX-License-Identifier: MIT
"""Local words, an index of parts: which words occur at a surface's keypoints, one bit for each.

Bags of heat kernel signatures depend on the whole shape: when a third of it is missing, their code is far
from that of the whole. The descriptors at the keypoints of a sample depend only on their neighbourhood (at
most a third of √area), so that a part has most of them in common with its whole. They have a vocabulary of
their own, much larger than that of the heat kernels, because only rare words identify a shape.

A shape that has the words of the query may have others as well, as a whole has more than its part. So codes
are not compared with each other; the words of the query are looked up in the code of each shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.registration.prepared_sample import SHARED_SCALES
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["LocalSettings", "LocalWords", "fit_local_words"]

# A training shape has the nearest words of its keypoints, this many of each: which of them is the very
# nearest depends on noise.
_NEAREST = 3
# Maximum numbers of descriptors and of samples that words and weights are learnt from.
_TRAINING_DESCRIPTORS, _TRAINING_SAMPLES = 300_000, 4_000


@dataclass(frozen=True)
class LocalSettings:
    """Size of the index of parts.

    Attributes
    ----------
    words : int
        Size V of the vocabulary, a multiple of 8.

    Raises
    ------
    ValueError
        If the number of words is not a positive multiple of 8.
    """

    words: int = 2048

    def __post_init__(self) -> None:
        if self.words < 8 or self.words % 8:
            raise ValueError(f"local words need a vocabulary of a positive multiple of 8, not {self.words}")


@dataclass(frozen=True, eq=False)
class LocalWords:
    """Vocabulary of the index of parts.

    Attributes
    ----------
    centers : (V, d) array of float32
        The words, in the unit of `SurfaceSample.descriptors`.
    weights : (V,) array of float32
        Inverse document frequencies (paper, equation 17).
    """

    centers: NDArray[np.float32]
    weights: NDArray[np.float32]

    def __post_init__(self) -> None:
        usable = {"centers": self.centers.ndim == 2, "weights": self.weights.shape == (len(self.centers),)}
        for name, right_shape in usable.items():
            if not (right_shape and np.isfinite(getattr(self, name)).all()):
                raise ModelError(f"the model's local words are damaged: {name}")

    @cached_property
    def _squares(self) -> NDArray[np.float32]:
        return np.asarray(np.einsum("ij,ij->i", self.centers, self.centers))

    def code(self, sample: SurfaceSample) -> NDArray[np.uint8]:
        """Encode which words a surface has.

        Parameters
        ----------
        sample : SurfaceSample

        Returns
        -------
        code : (V/8,) array of uint8
            One bit for each word: whether it is the nearest one of any keypoint. Packed as by
            `numpy.packbits`.
        """
        return np.packbits(self._counts(sample.descriptors) > 0)

    def query_weights(self, sample: SurfaceSample) -> NDArray[np.float32]:
        """Weigh the words of a query at each of `SHARED_SCALES`.

        Parameters
        ----------
        sample : SurfaceSample

        Returns
        -------
        weights : (scales, V) array of float32
            n_i w_i, where word i is the nearest one of n_i keypoints. A part and its whole both have unit
            area, so that the part is larger than in its whole: see `SurfaceSample.descriptors_at`.
        """
        counts = [self._counts(sample.descriptors_at(scale)) for scale in SHARED_SCALES]
        return np.array(counts, np.float32) * self.weights

    def nearest(self, descriptors: NDArray[np.float32], count: int) -> NDArray[np.intp]:
        """Find the nearest words of each descriptor.

        Parameters
        ----------
        descriptors : (k, d) array of float32
        count : int
            Number of words for each descriptor.

        Returns
        -------
        words : (k, count) array of int
            In no particular order.
        """
        return np.asarray(np.argpartition(self._distances(descriptors), count - 1, axis=1)[:, :count])

    def _counts(self, descriptors: NDArray[np.float32]) -> NDArray[np.intp]:
        return np.bincount(self._distances(descriptors).argmin(axis=1), minlength=len(self.centers))

    def _distances(self, descriptors: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return squared distances to all words, each less the squared length of the descriptor."""
        return np.asarray(self._squares - 2 * np.asarray(descriptors, np.float32) @ self.centers.T)


def fit_local_words(samples: Sequence[SurfaceSample], settings: LocalSettings, seed: int = 0) -> LocalWords:
    """Learn the words and their weights.

    Parameters
    ----------
    samples : sequence of SurfaceSample
        Samples of all versions of all training shapes.
    settings : LocalSettings
    seed : int, optional

    Returns
    -------
    local_words : LocalWords

    Raises
    ------
    ModelError
        If there are fewer descriptors than words.
    """
    # scikit-learn takes half a second to import, and only training needs it.
    from sklearn.cluster import MiniBatchKMeans

    from shapegoogle_core.words import InverseDocumentFrequency

    random = np.random.default_rng(seed)
    descriptors = np.concatenate([sample.descriptors for sample in samples])
    if len(descriptors) < settings.words:
        raise ModelError(
            f"{settings.words} local words cannot be learnt from {len(descriptors)} keypoints; "
            "give more shapes or fewer words"
        )
    if len(descriptors) > _TRAINING_DESCRIPTORS:
        descriptors = descriptors[random.choice(len(descriptors), _TRAINING_DESCRIPTORS, replace=False)]
    kmeans = MiniBatchKMeans(settings.words, n_init=1, batch_size=4096, max_iter=30, random_state=seed)
    centers = kmeans.fit(descriptors).cluster_centers_.astype(np.float32)
    words = LocalWords(centers, np.ones(settings.words, np.float32))
    if len(samples) > _TRAINING_SAMPLES:
        samples = [samples[index] for index in random.choice(len(samples), _TRAINING_SAMPLES, replace=False)]
    occurrences = np.zeros((len(samples), settings.words))
    for row, sample in zip(occurrences, samples, strict=True):
        row[words.nearest(sample.descriptors, _NEAREST)] = 1
    weights = InverseDocumentFrequency().fit(occurrences).weights_.astype(np.float32)
    return LocalWords(centers, weights)
