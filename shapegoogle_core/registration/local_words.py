# SPDX-License-Identifier: MIT
"""An index of parts: which words there are around a surface's keypoints, a bit for each.

Bags of heat kernels see the whole shape: where a third of it is gone, their code is far from the whole's. The
descriptors at the keypoints of a sample see only what is around them (a third of √area at most), so that most
of those of a part are those of its whole as well. They are told by words of their own, many more than the
heat kernels have, for a word has to be rare to say which shape it comes from.

A shape that has the words of the query may have any others too: a whole has more than its part. So no two
codes are compared, but the query's words are looked up in those of each shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.prepared_sample import SHARED_SCALES
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["LocalSettings", "LocalWords", "fit_local_words"]

# Each keypoint counts for so many of its nearest words: which of them is the nearest hangs on chance.
_NEAREST = 3
# What the words and the directions are learnt from, at most.
_TRAINING_DESCRIPTORS, _TRAINING_BAGS = 300_000, 4_000


@dataclass(frozen=True)
class LocalSettings:
    """Size of the index of parts.

    Attributes
    ----------
    words : int
        V, the size of its vocabulary.
    bits : int
        Length of the codes that libraries of format 4 had, a multiple of 8; see `LocalWords`.
    """

    words: int = 2048
    bits: int = 512

    def __post_init__(self) -> None:
        if self.words < 8 or self.words % 8 or self.bits < 8 or self.bits % 8:
            raise ValueError(f"local words need a multiple of 8 words and of 8 bits: {self}")


@dataclass(frozen=True, eq=False)
class LocalWords:
    """What is learnt of the index of parts.

    Attributes
    ----------
    centers : (V, d) array of float32
        The words, in the unit of `SurfaceSample.descriptors`.
    weights : (V,) array of float32
        Inverse document frequencies (paper, equation 17).
    mean, directions : (V,) array of float32, (s, V) array of int8
        Of the codes of libraries of format 4, which are compared no more. They are part of what models are
        told apart by.
    """

    centers: NDArray[np.float32]
    weights: NDArray[np.float32]
    mean: NDArray[np.float32]
    directions: NDArray[np.int8]

    def __post_init__(self) -> None:
        words, bits = len(self.centers), len(self.directions)
        expected = {"centers": 2, "weights": (words,), "mean": (words,), "directions": (bits, words)}
        for name, shape in expected.items():
            array = getattr(self, name)
            right = array.ndim == shape if isinstance(shape, int) else array.shape == shape
            if not (right and np.isfinite(array).all()):
                raise ModelError(f"the model's local words are damaged: {name}")

    @cached_property
    def _squares(self) -> NDArray[np.float32]:
        return np.asarray(np.einsum("ij,ij->i", self.centers, self.centers))

    def bag(self, descriptors: NDArray[np.float32]) -> NDArray[np.float32]:
        """Weighted bag of the words around some keypoints.

        Parameters
        ----------
        descriptors : (k, d) array

        Returns
        -------
        bag : (V,) array of float32
            f_i = w_i √n_i, of unit length; n_i keypoints have word i among their nearest three.
        """
        nearest = np.argpartition(self._distances(descriptors), _NEAREST - 1, axis=1)[:, :_NEAREST]
        counts = np.bincount(nearest.ravel(), minlength=len(self.centers))
        bag = np.sqrt(counts).astype(np.float32) * self.weights
        return np.asarray(bag / max(float(np.linalg.norm(bag)), 1e-30), np.float32)

    def code(self, sample: SurfaceSample) -> NDArray[np.uint8]:
        """Tell which words a surface has.

        Parameters
        ----------
        sample : SurfaceSample

        Returns
        -------
        code : (V/8,) array of uint8
            A bit for each word: whether it is the nearest one of a keypoint. Packed as by `numpy.packbits`.
        """
        return np.packbits(self._counts(sample.descriptors) > 0)

    def query_weights(self, sample: SurfaceSample) -> NDArray[np.float32]:
        """Weigh the words of what is looked for, at all sizes that it may have beside its match.

        Parameters
        ----------
        sample : SurfaceSample

        Returns
        -------
        weights : (scales, V) array of float32
            n_i w_i; n_i keypoints have word i as their nearest one. A part and its whole are both brought to
            unit area, so that the part is larger than it should be: see `SurfaceSample.descriptors_at`.
        """
        counts = [self._counts(sample.descriptors_at(scale)) for scale in SHARED_SCALES]
        return np.array(counts, np.float32) * self.weights

    def _counts(self, descriptors: NDArray[np.float32]) -> NDArray[np.intp]:
        return np.bincount(self._distances(descriptors).argmin(axis=1), minlength=len(self.centers))

    def _distances(self, descriptors: NDArray[np.float32]) -> NDArray[np.float32]:
        """Squares of the distances to all words, less something that is the same for all."""
        return np.asarray(self._squares - 2 * np.asarray(descriptors, np.float32) @ self.centers.T)


def fit_local_words(samples: Sequence[SurfaceSample], settings: LocalSettings, seed: int = 0) -> LocalWords:
    """Learn the words and their weights.

    Parameters
    ----------
    samples : sequence of SurfaceSample
        Of all versions of all training shapes.
    settings : LocalSettings
    seed : int

    Returns
    -------
    local_words : LocalWords

    Raises
    ------
    ModelError
        If there are fewer descriptors than words.
    """
    # These import scikit-learn: half a second that only training needs.
    from sklearn.cluster import MiniBatchKMeans

    from shapegoogle_core.words import InverseDocumentFrequency, rotated_components

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
    uniform = LocalWords(
        centers,
        np.ones(settings.words, np.float32),
        np.zeros(settings.words, np.float32),
        np.zeros((settings.bits, settings.words), np.int8),
    )
    if len(samples) > _TRAINING_BAGS:
        samples = [samples[index] for index in random.choice(len(samples), _TRAINING_BAGS, replace=False)]
    bags = np.array([uniform.bag(sample.descriptors) for sample in samples])
    weights = InverseDocumentFrequency().fit(bags).weights_.astype(np.float32)
    bags *= weights
    bags /= np.maximum(np.linalg.norm(bags, axis=1, keepdims=True), 1e-30)
    directions: FloatArray = rotated_components(bags.astype(np.float64), settings.bits, seed)
    directions *= 127 / np.abs(directions).max(axis=1, keepdims=True)
    return LocalWords(centers, weights, bags.mean(axis=0), np.rint(directions).astype(np.int8))
