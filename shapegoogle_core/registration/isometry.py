# SPDX-License-Identifier: MIT
"""Isometry test: is one shape a pose of another, judged by a functional map between their eigenfunctions.

A deformation that does not stretch the surface keeps the Laplacian, so the map between the eigenfunctions of
both shapes is a rotation that keeps their order (Ovsjanikov et al. 2012). It is found by refining an initial
guess on few eigenfunctions with more and more of them (ZoomOut, Melzi et al. 2019), here on the points of two
samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.frames import similarity_frame
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["Isometry", "IsometryTest", "functional_map", "shared_modes", "spectral_difference"]

# All combinations of signs of this number of eigenfunctions are initial guesses.
_GUESSED = 4
_STEP = 2  # eigenfunctions added in each refinement
# After this step only a few guesses are refined further: the best by then.
_PRUNED_AFTER, _KEPT = 1, 4
# Smaller eigenvalues belong to disconnected components.
_SMALLEST_EIGENVALUE = 1e-3
# Number of columns of the descriptors, the heat kernel signatures, that decide which guess is right.
_HEAT_COLUMNS = 5


@dataclass(frozen=True, eq=False)
class Isometry:
    """Best map found between the keypoints of two samples, and its deviation from an isometry.

    Attributes
    ----------
    counterparts : (k,) array of int
        Keypoint of the second sample for each one of the first.
    spectral_difference : float
        Root mean square of log(λ/μ) over the lowest eigenvalues λ and μ of both, each times its area.
    orthogonality : float
        ‖CᵀC - I‖ / √k with C the functional map: 0 if the map preserves areas.
    commutativity : float
        ‖C M - Λ C‖ / ‖Λ C‖ with the eigenvalues on the diagonals of Λ and M: 0 if it preserves lengths.
    displacement : float
        Difference of the poses: root mean square distance of counterparts in space, in units of √area, after
        the best similarity transformation of one shape onto the other.
    """

    counterparts: NDArray[np.intp]
    spectral_difference: float
    orthogonality: float
    commutativity: float
    displacement: float


class IsometryTest:
    """Compares one sample with others.

    Parameters
    ----------
    sample : SurfaceSample
    """

    def __init__(self, sample: SurfaceSample) -> None:
        self._sample = sample
        self._inverses: dict[int, NDArray[np.float32]] = {}

    def functional_map(self, other: SurfaceSample) -> Isometry:
        """Find the map to another sample that comes nearest to an isometry.

        Parameters
        ----------
        other : SurfaceSample

        Returns
        -------
        isometry : Isometry
        """
        first, second = self._sample, other
        size = min(len(first.eigenvalues), len(second.eigenvalues))
        here, there = first.modes[:, :size], second.modes[:, :size]
        heat = first.descriptors[:, :_HEAT_COLUMNS], second.descriptors[:, :_HEAT_COLUMNS]
        guessed = min(_GUESSED, size)
        # Eigenfunctions of nearly the same frequency may be swapped, so the descriptors help at first.
        target = np.concatenate([there[:, :guessed], heat[1]], axis=1)
        half_squares = (target**2).sum(axis=1) / 2
        maps = [
            _nearest(
                np.concatenate([here[:, :guessed] * np.array(signs, np.float32), heat[0]], axis=1),
                target,
                half_squares,
            )
            for signs in product((1, -1), repeat=guessed)
        ]
        counts = range(guessed, size + 1, _STEP)
        for step, count in enumerate(counts):
            images = [self._image(there, counterparts, count) for counterparts in maps]
            target = there[:, :count]
            half_squares = (target**2).sum(axis=1) / 2
            maps = [_nearest(here[:, :count] @ image, target, half_squares) for image in images]
            if step in (_PRUNED_AFTER, len(counts) - 1):
                misfits = [
                    float(np.abs(heat[0] - heat[1][counterparts]).mean()) + _orthogonality(image)
                    for counterparts, image in zip(maps, images, strict=True)
                ]
                maps = [maps[place] for place in np.argsort(misfits, kind="stable")[:_KEPT]]
        return _measure(first, second, maps[0], self._image(there, maps[0], counts[-1]))

    def _image(
        self, there: NDArray[np.float32], counterparts: NDArray[np.intp], count: int
    ) -> NDArray[np.float32]:
        """Return the functional map (c, c) of the first c eigenfunctions for a map of points."""
        if count not in self._inverses:
            # Keypoints represent equal areas, so the inverse is nearly the transposed matrix.
            self._inverses[count] = np.linalg.pinv(self._sample.modes[:, :count]).astype(np.float32)
        return np.asarray(self._inverses[count] @ there[counterparts, :count])


def functional_map(first: SurfaceSample, second: SurfaceSample) -> Isometry:
    """Find the map between two samples that comes nearest to an isometry.

    Parameters
    ----------
    first, second : SurfaceSample

    Returns
    -------
    isometry : Isometry
    """
    return IsometryTest(first).functional_map(second)


def spectral_difference(first: SurfaceSample, second: SurfaceSample) -> float:
    """Compare the lowest eigenvalues of two shapes (Shape-DNA, Reuter et al. 2006).

    Parameters
    ----------
    first, second : SurfaceSample

    Returns
    -------
    difference : float
        See `Isometry`; 0 if the shapes have no positive eigenvalues to compare.
    """
    size = min(len(first.eigenvalues), len(second.eigenvalues))
    values, others = first.eigenvalues[:size], second.eigenvalues[:size]
    positive = _both_positive(values, others)
    ratios = np.log(values[positive] / others[positive])
    return float(np.sqrt((ratios**2).mean())) if len(ratios) else 0.0


def shared_modes(first: SurfaceSample, second: SurfaceSample) -> int:
    """Count the lowest eigenfunctions that vary on both shapes.

    Of a shape with many separate parts most are constant on each part and say nothing about its form.

    Parameters
    ----------
    first, second : SurfaceSample

    Returns
    -------
    count : int
    """
    size = min(len(first.eigenvalues), len(second.eigenvalues))
    return int(_both_positive(first.eigenvalues[:size], second.eigenvalues[:size]).sum())


def _both_positive(values: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    return np.asarray((values > _SMALLEST_EIGENVALUE) & (others > _SMALLEST_EIGENVALUE))


def _nearest(
    rows: NDArray[np.float32], others: NDArray[np.float32], half_squares: NDArray[np.float32]
) -> NDArray[np.intp]:
    """Find the nearest of the others, given half of each one's squared length."""
    products = rows @ others.T
    return np.asarray(np.subtract(half_squares, products, out=products).argmin(axis=1))


def _orthogonality(image: NDArray[np.float32]) -> float:
    size = max(1, len(image))
    return float(np.linalg.norm(image.T @ image - np.eye(len(image), dtype=np.float32)) / np.sqrt(size))


def _measure(
    first: SurfaceSample, second: SurfaceSample, counterparts: NDArray[np.intp], image: NDArray[np.float32]
) -> Isometry:
    values, others = first.eigenvalues[: len(image)], second.eigenvalues[: len(image)]
    scaled = values[:, None] * image
    commutativity = float(np.linalg.norm(image * others - scaled)) / max(float(np.linalg.norm(scaled)), 1e-9)
    keys = len(counterparts)
    points, images = first.points[:keys], second.points[counterparts]
    moved = similarity_frame(points, images, np.ones(keys)).apply(points)
    gaps = ((moved - images) ** 2).sum(axis=1)
    return Isometry(
        counterparts=counterparts,
        spectral_difference=spectral_difference(first, second),
        orthogonality=_orthogonality(image),
        commutativity=commutativity,
        displacement=float(np.sqrt(gaps.mean())),
    )
