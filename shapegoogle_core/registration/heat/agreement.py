# SPDX-License-Identifier: MIT
"""Agreement of local heat: how well a part, bent in any way, fits somewhere into a whole.

Every point of the part is compared with the most similar point of the whole. A point near a cut is compared
only at times that are too short to feel it. No positions are used, so poses do not matter; that neighbours
stay neighbours is not checked. docs/measurements/parts.md has the measurements behind the constants.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.registration.heat.local_heat import HEAT_TIMES, LocalHeat

__all__ = ["HeatStack", "PartHeat", "heat_features", "whitened_heat"]

FloatArray32 = NDArray[np.float32]

# A cut is not felt at time t if it is farther away than this many √t.
_REACH = 2.0
# Number of the shortest times that are compared.
_TIMES = 5
# The 4 in `PartHeat.differences`: half a standard deviation counts as a clear difference, since what is not
# near a joint hardly differs.
_SHARPNESS = 4.0
# Share of the weight of all points at all times that must be known.
_LEAST_KNOWN = 0.06
# Covariance of the differences between points of parts in another pose, halves and thirds of 62 creatures
# that are not in any library, and the nearest points of their wholes (lower triangle). The first feature is
# the logarithm of the radius, the others are the values at the shortest times.
# `python -m benchmarks local-heat --learn` prints it.
_COVARIANCE = (
    (0.03898,),
    (0.00146, 0.00388),
    (0.00065, 0.00298, 0.00320),
    (-0.00005, 0.00199, 0.00258, 0.00291),
    (-0.00023, 0.00090, 0.00140, 0.00185, 0.00201),
    (0.00030, 0.00037, 0.00063, 0.00089, 0.00111, 0.00130),
)
# Share of the variances that is added to them, so that small differences of neighbouring times count less.
_RIDGE = 0.05


def _whitening() -> FloatArray32:
    """Compute L⁻ᵀ of the covariance L Lᵀ."""
    lower = np.zeros((_TIMES + 1, _TIMES + 1))
    for row, values in enumerate(_COVARIANCE):
        lower[row, : row + 1] = values
    covariance = lower + np.tril(lower, -1).T
    covariance += _RIDGE * np.diag(np.diag(covariance))
    return np.linalg.inv(np.linalg.cholesky(covariance)).T.astype(np.float32)


_WHITENING = _whitening()


def heat_features(heat: LocalHeat, scale: float = 1.0) -> tuple[FloatArray32, NDArray[np.int64]]:
    """Compute what is compared of a surface at another size.

    Parameters
    ----------
    heat : LocalHeat
    scale : float, optional
        Factor of all lengths, up to 1.

    Returns
    -------
    features : (k, 6) array of float32
        Logarithm of the radius, and values at the five shortest times.
    known : (k,) array of int
        Number of the times that are too short to feel a cut.
    """
    values, radii, margins = heat.at_scale(scale)
    known = (_REACH * np.sqrt(HEAT_TIMES[:_TIMES]) < margins[:, None]).sum(axis=1)
    return _compared(values, radii), known


def _compared(values: FloatArray32, radii: FloatArray32) -> FloatArray32:
    return np.concatenate([radii[:, None], values[:, :_TIMES]], axis=1)


def whitened_heat(heat: LocalHeat) -> FloatArray32:
    """Scale features so that differences of the same point have unit covariance.

    With the covariance L Lᵀ, z = L⁻¹ x has it. L is triangular, so the first m entries of z depend only on
    the first m features, and whiten these.

    Parameters
    ----------
    heat : LocalHeat
        Of a candidate.

    Returns
    -------
    features : (k, 6) array of float32
    """
    # All points of a candidate are compared: which times know a cut matters for the query only.
    return np.asarray(_compared(heat.values, heat.radii) @ _WHITENING)


class HeatStack:
    """Local heat of several candidates, arranged for products with that of queries.

    Parameters
    ----------
    candidates : (n, k, 6) array of float32
        From `whitened_heat`.
    """

    def __init__(self, candidates: FloatArray32) -> None:
        self._candidates = candidates
        self._arranged: dict[int, FloatArray32] = {}

    def __len__(self) -> int:
        return len(self._candidates)

    def least_squares(self, rows: FloatArray32) -> FloatArray32:
        """Compute the squared distance of each row from the nearest row of each candidate.

        Parameters
        ----------
        rows : (r, m) array of float32
            The first m whitened features of points of a query.

        Returns
        -------
        squares : (r, n) array of float32
        """
        # ‖x - y‖² = ‖x‖² - 2 (x·y - ‖y‖²/2): with one more column, the term in brackets is one product. A
        # second pass over a matrix of this size would take as long again.
        extended = np.concatenate([rows, np.ones((len(rows), 1), np.float32)], axis=1)
        products = extended @ self._columns(rows.shape[1])
        most = products.reshape(len(rows), len(self), -1).max(axis=2)
        squares = (rows**2).sum(axis=1)[:, None] - 2 * most
        return np.asarray(squares.clip(min=0), np.float32)

    def _columns(self, numbers: int) -> FloatArray32:
        """Arrange the first features and minus half their squared length as columns, once."""
        if numbers not in self._arranged:
            rows = self._candidates[:, :, :numbers].reshape(-1, numbers)
            halves = (rows**2).sum(axis=1, keepdims=True) / 2
            self._arranged[numbers] = np.ascontiguousarray(np.concatenate([rows, -halves], axis=1).T)
        return self._arranged[numbers]


class PartHeat:
    """Local heat of a query at one size, prepared for comparisons.

    Parameters
    ----------
    heat : LocalHeat
    scale : float
        Factor of the query's lengths, up to 1.
    points : int
        Number of the first points that are compared.
    """

    def __init__(self, heat: LocalHeat, scale: float, points: int) -> None:
        features, known = heat_features(heat.first(points), scale)
        whitened = features @ _WHITENING
        weight = int((known + 1)[known > 0].sum())
        self._groups: list[tuple[int, FloatArray32]] = []
        if weight >= _LEAST_KNOWN * len(known) * (_TIMES + 1):
            # The radius counts as one more number that is known.
            self._groups = [
                (times + 1, whitened[known == times, : times + 1])
                for times in np.unique(known[known > 0]).tolist()
            ]
        self._weight = weight

    def differences(self, candidates: HeatStack) -> FloatArray32:
        """Measure how much the query differs from what is most similar in each candidate.

        Where m numbers of a point are known and z is the difference of their whitened values from those of
        the most similar point, it differs by log(1 + 4 ‖z‖² / m). Its weight in the mean is m.

        Parameters
        ----------
        candidates : HeatStack
            Of n candidates.

        Returns
        -------
        differences : (n,) array of float32
            Infinite if too few points of the query are far enough from a cut.
        """
        if not self._groups:
            return np.full(len(candidates), np.inf, np.float32)
        total = np.zeros(len(candidates), np.float32)
        for numbers, rows in self._groups:
            squares = candidates.least_squares(rows)
            total += numbers * np.log1p(_SHARPNESS * squares / numbers).sum(axis=0)
        return np.asarray(total / self._weight, np.float32)
