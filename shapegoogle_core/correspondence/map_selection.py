# SPDX-License-Identifier: MIT
"""Selection of the best map: refinement of many initial maps, their costs, and the runners-up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.correspondence.functional_maps import (
    FunctionalMaps,
    PointMaps,
    nearest,
    project,
    zoom_out,
)
from shapegoogle_core.correspondence.initial_maps import initial_maps
from shapegoogle_core.correspondence.working_surface import WorkingSurface
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Candidate", "best_maps", "stretches"]

Indices = NDArray[np.int64]

# Sizes of the functional maps: of all candidates, and then of the best ones.
_COARSE = (8, 12, 16, 20, 25, 30)
_FINE_STEP = 5
_KEPT = 6
# For this number of the best maps, variants with the opposite sign of one eigenfunction are tried too: only
# the 20th or so distinguishes back and belly of a flat shape, and the initial maps do not include it.
_VARIED = 4
_LANDMARKS = 60  # points to which distances are compared to judge a refined map
# Two maps are the same if they send points on average to places closer than this, in units of √area, unless
# their orientations differ this much: on a slim shape the mirror image of every point is close.
_SAME, _SAME_ORIENTATION = 0.06, 0.5
# Extra cost of a map that turns the surface inside out.
_ORIENTATION_WEIGHT = 1.0
# For a mesh and itself both are 0; with these offsets neither decides alone.
_DISTORTION_OFFSET, _MISMATCH_OFFSET = 0.001, 0.01


@dataclass(frozen=True, eq=False)
class Candidate:
    """Candidate for the map between two shapes, with its costs.

    Attributes
    ----------
    maps : FunctionalMaps
    compared : PointMaps
        Map between the compared samples.
    distortion : float
        Mean difference between the distance of two points and that of their images, in both directions and
        in units of √area, plus the mean distance of points from their images under both maps in turn.
    orientation : float
        From −1, mirror image, to 1: see `orientation`. 0 where inside and outside are not known.
    mismatch : float
        Root mean square difference of the wave kernel signatures of points and their images, in units of
        their spread. Only refined maps have it.
    """

    maps: FunctionalMaps
    compared: PointMaps
    distortion: float
    orientation: float
    mismatch: float = 0.0

    @property
    def cost(self) -> float:
        """Cost of a refined candidate: distortion · mismatch², twice that for mirror images.

        On nearly round limbs an exchange of back and belly hardly changes distances, but it changes wave
        kernel signatures.
        """
        turned = 1 + _ORIENTATION_WEIGHT * (1 - self.orientation) / 2
        return (self.distortion + _DISTORTION_OFFSET) * (self.mismatch + _MISMATCH_OFFSET) ** 2 * turned


def best_maps(a: WorkingSurface, b: WorkingSurface) -> list[Candidate]:
    """Find maps between two shapes.

    Parameters
    ----------
    a, b : WorkingSurface

    Returns
    -------
    candidates : list of Candidate
        Different maps, the best first.
    """
    compared_a = a.spectrum.eigenvectors[a.compared]
    compared_b = b.spectrum.eigenvectors[b.compared]
    coarse = []
    for maps in initial_maps(a, b):
        refined = zoom_out(compared_a, compared_b, maps, _COARSE)
        fitted = project(compared_a, compared_b, refined, _largest(a, b, _COARSE[-1]))
        coarse.append(_candidate(a, b, fitted, refined))
    best = _different(sorted(coarse, key=attrgetter("distortion")), b.apart)
    for candidate in best[:_VARIED]:
        coarse += _variations(a, b, candidate)
    fine = [
        _refined(a, b, candidate)
        for candidate in _different(sorted(coarse, key=attrgetter("distortion")), b.apart)[:_KEPT]
    ]
    return _different(sorted(fine, key=attrgetter("cost")), b.apart)


def _variations(a: WorkingSurface, b: WorkingSurface, candidate: Candidate) -> list[Candidate]:
    """Make maps that agree with a candidate on low eigenfunctions and reverse the sign of the next one."""
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
    """Measure how much maps change distances; see `Candidate`.

    Parameters
    ----------
    a, b : WorkingSurface
    maps : PointMaps
        Maps between the compared samples.

    Returns
    -------
    distortion : float
    """
    forth, back = maps.forth, maps.back
    stretched = np.abs(a.apart - b.apart[np.ix_(forth, forth)]).mean()
    stretched += np.abs(b.apart - a.apart[np.ix_(back, back)]).mean()
    returned = a.apart[np.arange(len(forth)), back[forth]].mean()
    returned += b.apart[np.arange(len(back)), forth[back]].mean()
    return float(stretched + returned) / 2


def stretches(
    a: WorkingSurface, b: WorkingSurface, images: Indices, vertices: Indices | slice = slice(None)
) -> FloatArray:
    """Measure how much a map changes the distances of vertices of a from points all over a.

    Parameters
    ----------
    a, b : WorkingSurface
    images : (n,) array of int
        Image T(x) of each vertex x of a: the nearest vertex of b.
    vertices : (k,) array of int, optional
        Vertices x of a; all by default.

    Returns
    -------
    stretched : (k,) array
        Mean over the first samples s of |d_a(x, s) - d_b(T(x), T(s))| for each vertex x, in units of √area.
    """
    landmarks = a.compared[:_LANDMARKS]
    there = b.distances_to(images[landmarks])[images[vertices]]
    return np.asarray(np.abs(a.distances[vertices, : len(landmarks)] - there).mean(axis=1))


def orientation(a: WorkingSurface, b: WorkingSurface, maps: FunctionalMaps) -> float:
    """Measure whether a map preserves orientation.

    The positions and normals of b are pulled back to a by the functional map. The normals of the faces
    between these positions are compared with the normals pulled back.

    Parameters
    ----------
    a, b : WorkingSurface
    maps : FunctionalMaps

    Returns
    -------
    orientation : float
        From −1, where the map mirrors the whole surface, to 1.
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
    # The spacing of the compared samples alone is too coarse for the final choice.
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
    """Keep the first of each group of candidates that are the same map."""
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
