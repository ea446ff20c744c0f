# SPDX-License-Identifier: MIT
"""`GradientViews`: pictures described by whitened gradient histograms, and known in all 48 positions.

The projection treats a picture's symmetric and antisymmetric parts separately, so that mirroring a picture
changes the sign of some components and does nothing else. With the symmetries of the directions all turned
versions of a described shape are therefore known without drawing anything.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.views.directions import DIRECTIONS, Symmetry, symmetries
from shapegoogle_core.views.histograms import gradient_histograms, mirror_orbits

__all__ = ["CODE_BYTES", "POSES", "GradientViews", "gradient_parts", "learn_gradients"]

Floats = NDArray[np.float32]

POSES = 2
"""Straight, and in principal axes."""

CODE_BYTES = 64
"""Length of the binary code of a shape's views: half of it for each pose."""

# Chosen on procedural objects, upright and turned, and creatures (docs/concepts/views.md).
_WEIGHTS = np.array([0.4, 0.6], np.float32)
# Exponent of the eigenvalues that components are divided by: ½ would be a full whitening.
_POWER = 0.375
# Factors of the channels of a picture (normal to the right, up and towards the viewer) when it is mirrored.
_SIGNS = ((-1, 1), (1, -1), (1, 1))
_ORBITS = mirror_orbits(_SIGNS)
# Parts of a picture that are symmetric or antisymmetric left to right and top to bottom: ++ −+ +− −−. Columns
# are orthonormal combinations of an entry and its three mirror images.
_PARTS = np.array([[1, 1, 1, 1], [1, -1, 1, -1], [1, 1, -1, -1], [1, -1, -1, 1]], np.float32) / 2
_SYMMETRIES = symmetries()
# Positions that codes of a query are computed for: comparing codes takes a time in proportion. Straight
# shapes usually have the same axis up; principal axes are seldom exchanged.
_UPRIGHT = tuple(s for s in _SYMMETRIES if abs(s.matrix[2, 2]) == 1)
_FLIPPED = tuple(s for s in _SYMMETRIES if (np.abs(np.diag(s.matrix)) == 1).all())


@dataclass(frozen=True, eq=False)
class GradientViews:
    """What is learnt about gradients: a whitening projection, and the components that codes are made of.

    Attributes
    ----------
    mean : (m,) array of float32
        Mean of the symmetric part of the training pictures; that of the other parts is zero.
    projections : tuple of four (m, d_i) arrays of float16
        Whitened principal components of each part, see `gradient_parts`.
    code_components : (c,) array of int64
        Components whose signs are the code of each picture.

    Raises
    ------
    ModelError
        If the arrays do not fit together.
    """

    mean: Floats
    projections: tuple[NDArray[np.float16], ...]
    code_components: NDArray[np.int64]

    def __post_init__(self) -> None:
        length = len(_ORBITS)
        fits = (
            self.mean.shape == (length,)
            and len(self.projections) == len(_PARTS)
            and all(part.ndim == 2 and len(part) == length for part in self.projections)
            and np.isfinite(self.mean).all()
            and all(np.isfinite(part).all() for part in self.projections)
            and self.code_components.ndim == 1
            and DIRECTIONS * self.code_components.size <= 8 * CODE_BYTES // POSES
            and ((self.code_components >= 0) & (self.code_components < self.components)).all()
        )
        if not fits:
            raise ModelError("the model's views are damaged: their arrays do not fit together")

    @property
    def components(self) -> int:
        """Number d of components of each described picture."""
        return sum(part.shape[1] for part in self.projections)

    def project(self, parts: Floats) -> Floats:
        """Describe pictures.

        Parameters
        ----------
        parts : (n, 4, m) array of float32
            From `gradient_parts`; overwritten.

        Returns
        -------
        components : (n, d) array of float32
        """
        parts[:, 0] -= self.mean
        return np.concatenate(
            [parts[:, index] @ part for index, part in enumerate(self._projections)], axis=1
        )

    def positions(self, query: Floats) -> Floats:
        """Turn and mirror the pictures of a shape in all ways.

        Parameters
        ----------
        query : (2, 12, d) array

        Returns
        -------
        turned : (2, 48, 12 d) array
        """
        turned = np.stack([query[:, s.pictures] * signs for s, signs in self._signed], axis=1)
        return turned.reshape(POSES, len(_SYMMETRIES), -1)

    @staticmethod
    def distances(query: Floats, others: Floats) -> Floats:
        """Compute 1 − cos of corresponding pictures in the best positions, weighted over both poses.

        Parameters
        ----------
        query : (2, 48, 12 d) array
            From `positions`; vectors of pictures have unit length, or are zeros.
        others : (n, 2, 12, d) array
            Likewise.

        Returns
        -------
        distances : (n,) array
        """
        best = []
        for pose in range(POSES):
            products = query[pose] @ others[:, pose].reshape(len(others), -1).T
            best.append(products.max(axis=0) / DIRECTIONS)
        return np.asarray(1 - _WEIGHTS @ np.stack(best), np.float32)

    def code(self, descriptors: NDArray[np.int8]) -> NDArray[np.uint8]:
        """Compute the signs of the main components of pictures (2, 12, d), packed."""
        return _packed(descriptors[:, :, self.code_components] > 0).reshape(-1)

    def code_alternatives(self, code: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Compute the codes of a shape in other positions; see `ViewModel.code_alternatives`."""
        count = DIRECTIONS * len(self.code_components)
        bits = np.unpackbits(code.reshape(POSES, -1), axis=1, count=count).reshape(POSES, DIRECTIONS, -1)
        straight, principal = (
            np.stack([pose[s.pictures] * self._signs(s)[:, self.code_components] for s in positions])
            for pose, positions in zip(2 * bits.astype(np.int8) - 1, (_UPRIGHT, _FLIPPED), strict=True)
        )
        return _packed(straight > 0), _packed(principal > 0)

    @cached_property
    def _projections(self) -> tuple[Floats, ...]:
        return tuple(part.astype(np.float32) for part in self.projections)

    @cached_property
    def _mirrored(self) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
        """Signs (d,) of the components when a picture is mirrored left to right, and upside down."""
        widths = [part.shape[1] for part in self.projections]
        across, over = (np.repeat(np.sign(_PARTS[row]), widths).astype(np.int8) for row in (1, 2))
        return across, over

    @cached_property
    def _signed(self) -> list[tuple[Symmetry, NDArray[np.int8]]]:
        return [(symmetry, self._signs(symmetry)) for symmetry in _SYMMETRIES]

    def _signs(self, symmetry: Symmetry) -> NDArray[np.int8]:
        """Signs (12, d) that the components of each picture take on."""
        across, over = self._mirrored
        mirrored = symmetry.mirrored
        return np.where(mirrored[:, :1], across, 1) * np.where(mirrored[:, 1:], over, 1)


def gradient_parts(pictures: Floats) -> Floats:
    """Split the gradient histograms of pictures by symmetry.

    Parameters
    ----------
    pictures : (n, size, size, 3) array of float32
        From `normal_pictures`; their histograms are of pictures half as large.

    Returns
    -------
    parts : (n, 4, m) array of float32
        Parts that mirroring leaves alone, or turns into their negative: left to right, upside down.
    """
    rows = pictures[:, ::2] + pictures[:, 1::2]
    halved = (rows[:, :, ::2] + rows[:, :, 1::2]) * np.float32(0.25)
    histograms = gradient_histograms(halved)
    return np.asarray((histograms[:, _ORBITS] @ _PARTS).transpose(0, 2, 1), np.float32)


def learn_gradients(parts: NDArray[np.float64], components: int) -> GradientViews:
    """Learn the whitening of gradient histograms.

    Mirrored pictures count as much as the pictures themselves, so that the principal components of symmetric
    and antisymmetric parts are found one by one.

    Parameters
    ----------
    parts : (n, 4, m) array
        From `gradient_parts`; overwritten.
    components : int
        Components of all four parts together.

    Returns
    -------
    learnt : GradientViews
    """
    mean = parts[:, 0].mean(axis=0)
    parts[:, 0] -= mean
    values, vectors = zip(
        *(np.linalg.eigh(part.T @ part / len(parts)) for part in parts.transpose(1, 0, 2)), strict=True
    )
    least = np.sort(np.concatenate(values))[-components]
    kept = [part >= least for part in values]
    spread = [part[chosen] for part, chosen in zip(values, kept, strict=True)]
    projections = tuple(
        (directions[:, chosen] / part**_POWER).astype(np.float16)
        for directions, chosen, part in zip(vectors, kept, spread, strict=True)
    )
    coded = 8 * CODE_BYTES // POSES // DIRECTIONS
    order = np.argsort(-np.concatenate(spread), kind="stable")[:coded]
    return GradientViews(mean.astype(np.float32), projections, np.sort(order).astype(np.int64))


def _packed(bits: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Pack bits (…, 12, c) to codes (…, 32)."""
    flat = bits.reshape(*bits.shape[:-2], -1)
    room = 8 * CODE_BYTES // POSES
    padded = np.zeros((*flat.shape[:-1], room), bool)
    padded[..., : flat.shape[-1]] = flat
    return np.packbits(padded, axis=-1)
