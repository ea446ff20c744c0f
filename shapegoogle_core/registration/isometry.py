# SPDX-License-Identifier: MIT
"""Whether one shape is a pose of another: a functional map between their lowest eigenfunctions.

A bend that stretches nothing keeps the Laplacian, so the map between both shapes' eigenfunctions is a
rotation that keeps their order (Ovsjanikov et al. 2012). It is found by refining a rough guess of few
eigenfunctions with more and more of them (ZoomOut, Melzi et al. 2019), here on the points of two samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.registration.frames import similarity_transformations
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["Isometry", "functional_map", "spectral_difference"]

# Signs of so many eigenfunctions are guessed, in all ways.
_GUESSED = 4
_STEP = 2
# Smaller ones are those of parts that hang together by nothing.
_LEAST_EIGENVALUE = 1e-3
# What a point looks like tells which guess is right.
_HEAT_COLUMNS = 5


@dataclass(frozen=True, eq=False)
class Isometry:
    """The best map found from one sample's points to another's, and how far it is from an isometry.

    Attributes
    ----------
    counterparts : (k,) array of int
        For each keypoint of the first sample one of the second's.
    spectral_difference : float
        Root mean square of log(λ/μ) over the lowest eigenvalues λ and μ of both, each times its area.
    orthogonality : float
        ‖CᵀC - I‖ / √k with C the functional map: 0 if the map keeps areas.
    commutativity : float
        ‖C M - Λ C‖ / ‖Λ C‖ with the eigenvalues on the diagonals of Λ and M: 0 if it keeps lengths.
    displacement : float
        Root mean square distance of counterparts in space, in units of √area, once one shape is moved onto
        the other as well as can be: how far the pose differs.
    """

    counterparts: NDArray[np.intp]
    spectral_difference: float
    orthogonality: float
    commutativity: float
    displacement: float


def functional_map(first: SurfaceSample, second: SurfaceSample) -> Isometry:
    """Find the map between two samples that is most nearly an isometry.

    Parameters
    ----------
    first, second : SurfaceSample

    Returns
    -------
    isometry : Isometry
    """
    size = min(len(first.eigenvalues), len(second.eigenvalues))
    here, there = first.modes[:, :size], second.modes[:, :size]
    looks = first.descriptors[:, :_HEAT_COLUMNS], second.descriptors[:, :_HEAT_COLUMNS]
    guessed = min(_GUESSED, size)
    counts = range(guessed, size + 1, _STEP)
    # Keypoints stand for equal areas, so these are nearly the transposed.
    inverses = [np.linalg.pinv(here[:, :count]).astype(np.float32) for count in counts]
    best: tuple[float, NDArray[np.intp]] | None = None
    for signs in product((1, -1), repeat=guessed):
        # At first the descriptors help: eigenfunctions of nearly the same frequency may have changed places.
        start = np.concatenate([here[:, :guessed] * np.array(signs, np.float32), looks[0]], axis=1)
        target = np.concatenate([there[:, :guessed], looks[1]], axis=1)
        counterparts = _nearest(start, target)
        for count, inverse in zip(counts, inverses, strict=True):
            image = inverse @ there[counterparts, :count]
            counterparts = _nearest(here[:, :count] @ image, there[:, :count])
        misfit = float(np.abs(looks[0] - looks[1][counterparts]).mean()) + _orthogonality(image)
        if best is None or misfit < best[0]:
            best = misfit, counterparts
    assert best is not None
    counterparts = best[1]
    image = inverses[-1] @ there[counterparts, : counts[-1]]
    return _measure(first, second, counterparts, image)


def spectral_difference(first: SurfaceSample, second: SurfaceSample) -> float:
    """Compare the lowest eigenvalues of two shapes (Shape-DNA, Reuter et al. 2006).

    Parameters
    ----------
    first, second : SurfaceSample

    Returns
    -------
    difference : float
        See `Isometry`; 0 for shapes that have none in common.
    """
    size = min(len(first.eigenvalues), len(second.eigenvalues))
    values, others = first.eigenvalues[:size], second.eigenvalues[:size]
    positive = (values > _LEAST_EIGENVALUE) & (others > _LEAST_EIGENVALUE)
    ratios = np.log(values[positive] / others[positive])
    return float(np.sqrt((ratios**2).mean())) if len(ratios) else 0.0


def _nearest(rows: NDArray[np.float32], others: NDArray[np.float32]) -> NDArray[np.intp]:
    return np.asarray(((others**2).sum(axis=1) / 2 - rows @ others.T).argmin(axis=1))


def _orthogonality(image: NDArray[np.float32]) -> float:
    size = max(1, len(image))
    return float(np.linalg.norm(image.T @ image - np.eye(len(image))) / np.sqrt(size))


def _measure(
    first: SurfaceSample,
    second: SurfaceSample,
    counterparts: NDArray[np.intp],
    image: NDArray[np.float32],
) -> Isometry:
    values, others = first.eigenvalues[: len(image)], second.eigenvalues[: len(image)]
    scaled = values[:, None] * image
    commutativity = float(np.linalg.norm(image * others - scaled)) / max(float(np.linalg.norm(scaled)), 1e-9)
    keys = len(counterparts)
    scales, rotations, translations = similarity_transformations(
        first.points[None, :keys], second.points[None, counterparts], np.ones((1, keys))
    )
    moved = scales[0] * first.points[:keys] @ rotations[0].T + translations[0]
    gaps = ((moved - second.points[counterparts]) ** 2).sum(axis=1)
    return Isometry(
        counterparts=counterparts,
        spectral_difference=spectral_difference(first, second),
        orthogonality=_orthogonality(image),
        commutativity=commutativity,
        displacement=float(np.sqrt(gaps.mean())),
    )
