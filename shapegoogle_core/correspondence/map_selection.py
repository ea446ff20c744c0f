# SPDX-License-Identifier: MIT
"""From many first maps to the best one: refinement, figures of merit, and what competes with it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.correspondence.functional_maps import (
    FunctionalMaps,
    PointMaps,
    nearest,
    project,
    zoom_out,
)
from shapegoogle_core.correspondence.initial_maps import first_maps
from shapegoogle_core.correspondence.working_surface import WorkingSurface
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Candidate", "best_maps", "stretches"]

Indices = NDArray[np.int64]

# Sizes of the functional maps: for all candidates, and then for the best of them.
_COARSE = (8, 12, 16, 20, 25, 30)
_FINE_STEP = 5
_KEPT = 6
# Of so many of the best, the maps that differ in the sign of one of the eigenfunctions are tried too: back
# and belly of a flat shape are told apart only by the 20th or so, of which the first maps know nothing.
_VARIED = 4
_LANDMARKS = 60  # distances to so many points tell how good a refined map is
# Maps that on average send a point to places closer than this, in units of √area, are the same map, unless
# their orientations are so much apart: on a slim shape the mirror image of every point is close.
_SAME, _SAME_ORIENTATION = 0.06, 0.5
# How much better a map that turns the surface inside out has to fit than one that does not.
_ORIENTATION_WEIGHT = 1.0
# Of a mesh with itself both are 0, and then neither decides alone.
_LEAST_DISTORTION, _LEAST_MISMATCH = 0.001, 0.01


@dataclass(frozen=True, eq=False)
class Candidate:
    """A map and how good it is.

    Attributes
    ----------
    maps : FunctionalMaps
    compared : PointMaps
        Between the compared samples.
    distortion : float
        Mean difference of the distances of two points and of their images, both ways, in units of √area,
        plus the mean distance after going there and back.
    orientation : float
        From −1, mirror image, to 1: see `orientation`. 0 where inside and outside are not known.
    mismatch : float
        Root mean square difference of the wave kernel signatures of points and their images, in units of
        their spread; only known of refined maps.
    """

    maps: FunctionalMaps
    compared: PointMaps
    distortion: float
    orientation: float
    mismatch: float = 0.0

    @property
    def cost(self) -> float:
        """What the refined candidates are ordered by: distortion · mismatch², twice that for mirror images.

        On limbs that are near to round, what goes wrong with back and belly hardly changes distances, but
        what waves see of the surroundings.
        """
        turned = 1 + _ORIENTATION_WEIGHT * (1 - self.orientation) / 2
        return (self.distortion + _LEAST_DISTORTION) * (self.mismatch + _LEAST_MISMATCH) ** 2 * turned


def best_maps(a: WorkingSurface, b: WorkingSurface) -> list[Candidate]:
    """Find maps between two shapes.

    Parameters
    ----------
    a, b : WorkingSurface

    Returns
    -------
    candidates : list of Candidate
        Different ones, the best first.
    """
    compared_a = a.spectrum.eigenvectors[a.compared]
    compared_b = b.spectrum.eigenvectors[b.compared]
    coarse = []
    for maps in first_maps(a, b):
        refined = zoom_out(compared_a, compared_b, maps, _COARSE)
        fitted = project(compared_a, compared_b, refined, _largest(a, b, _COARSE[-1]))
        coarse.append(_candidate(a, b, fitted, refined))
    best = _different(sorted(coarse, key=_distortion), b.apart)
    for candidate in best[:_VARIED]:
        coarse += _variations(a, b, candidate)
    fine = [
        _refined(a, b, candidate)
        for candidate in _different(sorted(coarse, key=_distortion), b.apart)[:_KEPT]
    ]
    return _different(sorted(fine, key=lambda candidate: candidate.cost), b.apart)


def _distortion(candidate: Candidate) -> float:
    return candidate.distortion


def _variations(a: WorkingSurface, b: WorkingSurface, candidate: Candidate) -> list[Candidate]:
    """Make maps that agree with a candidate on the lowest eigenfunctions and then turn one around."""
    functions_a = a.spectrum.eigenvectors[a.compared]
    functions_b = b.spectrum.eigenvectors[b.compared]
    varied = []
    for turned in range(1, len(candidate.maps.to_a)):
        signs = np.ones(turned + 1)
        signs[turned] = -1
        lower = slice(turned + 1)
        maps = FunctionalMaps(
            candidate.maps.to_a[lower, lower] * signs, signs[:, None] * candidate.maps.to_b[lower, lower]
        )
        start = _point_maps(functions_a, functions_b, maps)
        sizes = [k for k in _COARSE if k > turned + 1]
        refined = zoom_out(functions_a, functions_b, start, sizes or _COARSE[-1:])
        fitted = project(functions_a, functions_b, refined, _largest(a, b, _COARSE[-1]))
        varied.append(_candidate(a, b, fitted, refined))
    return varied


def _point_maps(functions_a: FloatArray, functions_b: FloatArray, maps: FunctionalMaps) -> PointMaps:
    places_a, places_b = maps.embed_a(functions_a), maps.embed_b(functions_b)
    return PointMaps(nearest(places_a, places_b), nearest(places_b, places_a))


def distortion(a: WorkingSurface, b: WorkingSurface, maps: PointMaps) -> float:
    """Measure how little maps keep distances; see `Candidate`."""
    forth, back = maps.forth, maps.back
    stretched = np.abs(a.apart - b.apart[np.ix_(forth, forth)]).mean()
    stretched += np.abs(b.apart - a.apart[np.ix_(back, back)]).mean()
    returned = a.apart[np.arange(len(forth)), back[forth]].mean()
    returned += b.apart[np.arange(len(back)), forth[back]].mean()
    return float(stretched + returned) / 2


def stretches(
    a: WorkingSurface, b: WorkingSurface, images: Indices, vertices: Indices | slice = slice(None)
) -> FloatArray:
    """Measure how little a map keeps the distances of vertices of a to points all over a.

    Parameters
    ----------
    a, b : WorkingSurface
    images : (n,) array of int
        For each vertex of a the nearest vertex of b.
    vertices : array of int, optional
        Of a; all when left out.

    Returns
    -------
    stretched : array
        For each of them the mean over the first samples of |d_a(x, s) - d_b(T(x), T(s))|, in units of √area.
    """
    landmarks = a.compared[:_LANDMARKS]
    there = b.distances_to(images[landmarks])[images[vertices]]
    stretched: FloatArray = np.abs(a.distances[vertices, : len(landmarks)] - there).mean(axis=1)
    return stretched


def orientation(a: WorkingSurface, b: WorkingSurface, maps: FunctionalMaps) -> float:
    """Measure whether a map keeps the sense of rotation.

    The positions and the normals of b are pulled back to a by the functional map, and the normals of the
    faces that this makes are compared with the normals pulled back.

    Parameters
    ----------
    a, b : WorkingSurface
    maps : FunctionalMaps

    Returns
    -------
    orientation : float
        From −1, all of the surface comes out mirrored, to 1.
    """
    if not (a.outward and b.outward):
        return 0.0
    k = len(maps.to_a)
    pulled = a.spectrum.eigenvectors[:, :k] @ (maps.to_a @ b.coordinates[:k])
    positions, normals = pulled[:, :3], pulled[:, 3:]
    p, q, r = (positions[a.faces[:, corner]] for corner in range(3))
    doubled = np.cross(q - p, r - p)
    agreement = (doubled * normals[a.faces].mean(axis=1)).sum(axis=1)
    return float(agreement.sum() / max(np.abs(agreement).sum(), np.finfo(float).tiny))


def _candidate(a: WorkingSurface, b: WorkingSurface, maps: FunctionalMaps, compared: PointMaps) -> Candidate:
    return Candidate(maps, compared, distortion(a, b, compared), orientation(a, b, maps))


def _refined(a: WorkingSurface, b: WorkingSurface, candidate: Candidate) -> Candidate:
    functions_a = a.spectrum.eigenvectors[a.samples]
    functions_b = b.spectrum.eigenvectors[b.samples]
    start = _point_maps(functions_a, functions_b, candidate.maps)
    largest = _largest(a, b, max(functions_a.shape[1], functions_b.shape[1]))
    sizes = [*range(min(_COARSE[-1], largest), largest, _FINE_STEP), largest]
    refined = zoom_out(functions_a, functions_b, start, sizes)
    maps = project(functions_a, functions_b, refined, largest)
    compared = _point_maps(a.spectrum.eigenvectors[a.compared], b.spectrum.eigenvectors[b.compared], maps)
    # Among the compared samples alone an image is half their spacing off: too coarse for the last choice.
    whole = _point_maps(a.spectrum.eigenvectors, b.spectrum.eigenvectors, maps)
    stretched = (
        stretches(a, b, whole.forth, a.compared).mean() + stretches(b, a, whole.back, b.compared).mean()
    )
    returned = a.distances[whole.back[whole.forth[a.compared]], np.arange(len(a.compared))].mean()
    returned += b.distances[whole.forth[whole.back[b.compared]], np.arange(len(b.compared))].mean()
    mismatch = (_mismatch(a, b, whole.forth) + _mismatch(b, a, whole.back)) / 2
    return Candidate(maps, compared, float(stretched + returned) / 2, orientation(a, b, maps), mismatch)


def _mismatch(a: WorkingSurface, b: WorkingSurface, images: Indices) -> float:
    squares = ((a.waves - b.waves[images]) ** 2).sum(axis=1)
    return math.sqrt(float(a.spectrum.mass @ squares) / a.spectrum.area)


def _largest(a: WorkingSurface, b: WorkingSurface, k: int) -> int:
    return min(k, len(a.spectrum.eigenvalues), len(b.spectrum.eigenvalues))


def _different(candidates: list[Candidate], distances: FloatArray) -> list[Candidate]:
    """Keep the first of each group that are the same map."""
    kept: list[Candidate] = []
    for candidate in candidates:
        alike = (
            abs(candidate.orientation - other.orientation) < _SAME_ORIENTATION
            and distances[candidate.compared.forth, other.compared.forth].mean() < _SAME
            for other in kept
        )
        if not any(alike):
            kept.append(candidate)
    return kept
