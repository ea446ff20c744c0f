# SPDX-License-Identifier: MIT
"""`NetworkViews`: pictures described by whitened features of a network.

The network was trained on upright photographs and knows no symmetries that could be had without drawing, so
its pictures are compared as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.views.directions import OPPOSITES
from shapegoogle_core.views.network import FEATURES, NETWORK_DIGEST, network_features

__all__ = ["NETWORK_PICTURES", "NetworkViews", "learn_network"]

Floats = NDArray[np.float32]

# Of two opposite directions one is enough: their outlines are mirror images.
_FRONT = [front for front, _ in OPPOSITES]
NETWORK_PICTURES = len(_FRONT)
"""Pictures of each pose that the network sees."""


@dataclass(frozen=True, eq=False)
class NetworkViews:
    """What is learnt about a network's features: a whitening projection.

    Attributes
    ----------
    mean : (1280,) array of float32
        Mean of the features of the training pictures.
    projection : (1280, d) array of float16
        Their principal components, divided by their standard deviation.
    digest : str
        `NETWORK_DIGEST` of the network.

    Raises
    ------
    ModelError
        If the arrays do not fit together.
    """

    mean: Floats
    projection: NDArray[np.float16]
    digest: str

    def __post_init__(self) -> None:
        fits = (
            self.mean.shape == (FEATURES,)
            and self.projection.ndim == 2
            and len(self.projection) == FEATURES
            and np.isfinite(self.mean).all()
            and np.isfinite(self.projection).all()
        )
        if not fits:
            raise ModelError("the model's views are damaged: their arrays do not fit together")

    @property
    def components(self) -> int:
        """Number d of components of each described picture."""
        return int(self.projection.shape[1])

    def describe(self, pictures: Floats) -> Floats:
        """Describe the pictures of some poses.

        Parameters
        ----------
        pictures : (p, 12, size, size, 3) array of float32
            From `normal_pictures`, of each pose.

        Returns
        -------
        components : (p · 6, d) array of float32

        Raises
        ------
        ModelError
            If the network cannot be used, or is not the one that this was learnt for.
        """
        if self.digest != NETWORK_DIGEST:
            raise ModelError(
                f"the model's views were learnt with another network ({self.digest}) than that of this "
                f"version of Shape Google ({NETWORK_DIGEST}); update Shape Google, or train the model again"
            )
        return np.asarray((features_of(pictures) - self.mean) @ self._projection, np.float32)

    @staticmethod
    def distances(query: Floats, others: Floats) -> Floats:
        """Compute 1 − cos of corresponding pictures: the mean over a pose, the least of both poses.

        Parameters
        ----------
        query : (2, 6, d) array
            Vectors of unit length, or zeros.
        others : (n, 2, 6, d) array

        Returns
        -------
        distances : (n,) array
        """
        cosines = [
            others[:, pose].reshape(len(others), -1) @ query[pose].reshape(-1) for pose in range(len(query))
        ]
        return np.asarray(1 - np.max(cosines, axis=0) / NETWORK_PICTURES, np.float32)

    @cached_property
    def _projection(self) -> Floats:
        return self.projection.astype(np.float32)


def features_of(pictures: Floats) -> Floats:
    """Compute the network's features of one of each two opposite directions.

    Parameters
    ----------
    pictures : (p, 12, size, size, 3) array of float32

    Returns
    -------
    features : (p · 6, 1280) array of float32
    """
    seen = pictures[:, _FRONT]
    return network_features(seen.reshape(-1, *seen.shape[2:]))


def learn_network(features: NDArray[np.float64], components: int) -> NetworkViews:
    """Learn the whitening of features.

    Parameters
    ----------
    features : (n, 1280) array
        From `features_of`.
    components : int

    Returns
    -------
    learnt : NetworkViews
    """
    mean = features.mean(axis=0)
    centred = features - mean
    values, vectors = np.linalg.eigh(centred.T @ centred / len(centred))
    projection = vectors[:, -components:] / np.sqrt(values[-components:])
    return NetworkViews(mean.astype(np.float32), projection.astype(np.float16), NETWORK_DIGEST)
