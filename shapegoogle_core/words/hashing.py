# SPDX-License-Identifier: MIT
"""Similarity-sensitive hashing of vectors to short binary codes (paper, section 5, algorithm 1)."""

from __future__ import annotations

from typing import Self

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from sklearn.base import BaseEstimator
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_array

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.words.estimators import check_features, learn_features

__all__ = ["SimilaritySensitiveHashing", "best_threshold", "rotated_components"]


class SimilaritySensitiveHashing(BaseEstimator):  # type: ignore[misc]
    """Binary codes in which similar shapes differ in few bits, y(f) = sign(A f + b) (paper, equation 19).

    Each bit is a weak classifier of pairs into similar and dissimilar ones. AdaBoost chooses them one after
    the other (algorithm 1): a direction and a threshold that minimise the exponential loss, after which the
    pairs that this bit classifies wrongly get more weight.

    Parameters
    ----------
    bits : int
        s, the length of the code.
    projection : {"eigenvectors", "random"}
        Source of the candidate directions of each bit: the `candidates` generalised eigenvectors of largest
        eigenvalue of (C_N, C_P), the covariances of f - f' over negative and positive pairs under the current
        boosting weights (equation 21); or as many random directions (Shakhnarovich 2005).
    candidates : int
        Number of candidate directions of each bit.
    regularization : float
        Share of its mean diagonal that is added to the diagonal of C_P. It is a share, so that the unit of
        the vectors does not matter.
    random_state : int, RandomState or None
        Seed or generator of the random directions.

    Attributes
    ----------
    directions_ : (s, d) array
        A, rows of unit length.
    thresholds_ : (s,) array
        b.
    losses_ : (s,) array
        Weighted exponential loss of each bit when it was chosen: e⁻¹ is perfect, cosh 1 ≈ 1.54 no better
        than chance for a balanced set.
    n_features_in_ : int
        d, the length of the vectors.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> random = np.random.default_rng(0)
    >>> shapes = random.standard_normal((100, 4))
    >>> versions = shapes + 0.1 * random.standard_normal((100, 4))
    >>> first, second = np.tile(shapes, (2, 1)), np.concatenate([versions, np.roll(versions, 1, axis=0)])
    >>> hashing = sg.SimilaritySensitiveHashing(bits=16).fit(first, second, similar=np.arange(200) < 100)
    >>> different = hashing.transform(first) != hashing.transform(second)
    >>> bool(different[:100].mean() < 0.2), bool(different[100:].mean() > 0.4)
    (True, True)
    """

    def __init__(
        self,
        bits: int = 64,
        *,
        projection: str = "eigenvectors",
        candidates: int = 10,
        regularization: float = 1e-2,
        random_state: int | np.random.RandomState | None = 0,
    ) -> None:
        self.bits = bits
        self.projection = projection
        self.candidates = candidates
        self.regularization = regularization
        self.random_state = random_state

    def fit(self, first: FloatArray, second: FloatArray, similar: NDArray[np.bool_]) -> Self:
        """Learn A and b from labelled pairs.

        Parameters
        ----------
        first, second : (P, d) array
            Vectors f and f' of each pair.
        similar : (P,) array of bool
            Whether the pair is positive: a shape and another version of it.

        Returns
        -------
        self : SimilaritySensitiveHashing

        Raises
        ------
        ValueError
            If the shapes of the arrays differ, one kind of pair is missing, or a parameter is out of range.
        """
        if self.projection not in ("eigenvectors", "random"):
            raise ValueError(f"projection must be 'eigenvectors' or 'random', not {self.projection!r}")
        if self.bits < 1 or self.candidates < 1:
            raise ValueError("bits and candidates must be at least 1")
        first = learn_features(self, first)
        second = check_array(second, dtype=np.float64)
        similar = np.asarray(similar, dtype=bool)
        if first.shape != second.shape or similar.shape != (len(first),):
            raise ValueError(
                f"pairs do not fit: first is {first.shape}, second {second.shape}, similar {similar.shape}"
            )
        if similar.all() or not similar.any():
            raise ValueError("similar must hold positive and negative pairs")
        random = check_random_state(self.random_state)
        sign = np.where(similar, 1.0, -1.0)
        differences = first - second
        # Both kinds start with half of the weight, whatever their numbers of pairs (equation 20).
        weights = np.where(similar, 0.5 / similar.sum(), 0.5 / (~similar).sum())
        self.directions_ = np.empty((self.bits, first.shape[1]))
        self.thresholds_ = np.empty(self.bits)
        self.losses_ = np.empty(self.bits)
        for bit in range(self.bits):
            if self.projection == "random":
                directions = random.standard_normal((self.candidates, first.shape[1]))
            else:
                directions = self._eigenvectors(differences, similar, weights)
            directions /= np.linalg.norm(directions, axis=1, keepdims=True)
            trials = [
                best_threshold(a, b, sign * weights)
                for a, b in zip(directions @ first.T, directions @ second.T, strict=True)
            ]
            best = int(np.argmax([agreement for _, agreement in trials]))
            threshold, _ = trials[best]
            self.directions_[bit] = directions[best]
            self.thresholds_[bit] = threshold
            same = (first @ directions[best] + threshold > 0) == (second @ directions[best] + threshold > 0)
            loss = weights * np.exp(-sign * np.where(same, 1.0, -1.0))
            self.losses_[bit] = loss.sum()
            weights = loss / loss.sum()
        return self

    def _eigenvectors(
        self, differences: FloatArray, similar: NDArray[np.bool_], weights: FloatArray
    ) -> FloatArray:
        """Find directions of large spread of negative pairs, relative to positive ones (equation 21)."""
        positive, negative = differences[similar], differences[~similar]
        covariance_positive = (positive * weights[similar, None]).T @ positive / weights[similar].sum()
        covariance_negative = (negative * weights[~similar, None]).T @ negative / weights[~similar].sum()
        dimension = len(covariance_positive)
        ridge = self.regularization * np.trace(covariance_positive) / dimension
        # If all positive pairs are equal they have no spread: the bound comes from the negative pairs.
        ridge = max(ridge, 1e-12 * np.trace(covariance_negative) / dimension)
        covariance_positive[np.diag_indices(dimension)] += ridge
        count = min(self.candidates, dimension)
        _, vectors = scipy.linalg.eigh(
            covariance_negative, covariance_positive, subset_by_index=[dimension - count, dimension - 1]
        )
        return np.ascontiguousarray(vectors.T)

    def transform(self, X: FloatArray) -> NDArray[np.bool_]:
        """Embed vectors into the Hamming space.

        Parameters
        ----------
        X : (n, d) array
            Vectors f.

        Returns
        -------
        bits : (n, s) array of bool
            y = A f + b > 0.

        Raises
        ------
        NotFittedError
            If the estimator was not fitted.
        ValueError
            If X is not finite or its vectors have another length than those of `fit`.
        """
        vectors = check_features(self, X)
        return vectors @ self.directions_.T + self.thresholds_ > 0


def best_threshold(first: FloatArray, second: FloatArray, signed_weights: FloatArray) -> tuple[float, float]:
    """Find the b for which sign(p + b) sign(p' + b) agrees best with the labels (algorithm 1, step 3).

    Maximises Σ_p w_p s_p sign(p + b) sign(p' + b), which is the same as minimising the exponential loss
    Σ_p w_p exp(-s_p sign(p + b) sign(p' + b)), because the product of signs is ±1.

    Parameters
    ----------
    first, second : (P,) array
        Projections A_i f and A_i f' of both vectors of each pair.
    signed_weights : (P,) array
        w_p s_p, weight and label (±1) of each pair.

    Returns
    -------
    threshold : float
        b.
    agreement : float
        Maximum of the sum.
    """
    # A pair is split by those -b that lie between its two projections: so the sum over split pairs is one
    # over the intervals that contain -b, accumulated over their sorted ends.
    starts, ends = np.minimum(first, second), np.maximum(first, second)
    positions = np.concatenate([starts, ends])
    order = np.argsort(positions, kind="stable")
    positions = positions[order]
    split = np.cumsum(np.concatenate([signed_weights, -signed_weights])[order])
    # Between two equal positions there is no threshold; the last interval lies outside all pairs.
    usable = np.append(positions[1:] > positions[:-1], False)
    if not usable.any():
        return float(-positions[0]), float(signed_weights.sum())
    split = np.where(usable, split, np.inf)
    best = int(np.argmin(split))
    threshold = -0.5 * (positions[best] + positions[best + 1])
    return float(threshold), float(signed_weights.sum() - 2 * split[best])


def rotated_components(vectors: FloatArray, bits: int, random_state: int = 0) -> FloatArray:
    """Draw directions of a code that needs no pairs: random rotations of the principal components.

    The leading components have most of the variance, but in unequal shares; a rotation gives every bit the
    same share (Jégou et al. 2010). Unlike boosting it uses no pairs, so that it cannot overfit them.

    Parameters
    ----------
    vectors : (n, d) array
        Training vectors.
    bits : int
        s. The s leading components are rotated; if there are fewer, all of them in several rotations.
    random_state : int
        Seed of the rotations.

    Returns
    -------
    directions : (s, d) array
        Rows of unit length.
    """
    _, components = scipy.linalg.eigh(np.atleast_2d(np.cov(vectors.T)))
    leading = components[:, ::-1][:, :bits]
    random = np.random.default_rng(random_state)
    size = leading.shape[1]
    rotations = [np.linalg.qr(random.standard_normal((size, size)))[0] for _ in range(-(-bits // size))]
    return np.concatenate(rotations)[:bits] @ leading.T
