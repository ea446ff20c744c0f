# SPDX-License-Identifier: MIT
"""Comparison of two meshes by their measures: copies, other triangulations of a surface, mirror images."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.measures.mesh_measures import WAVELENGTHS, MeshMeasures
from shapegoogle_core.registration.measures.moments import full, principal_axes

__all__ = [
    "are_flat_sided",
    "handed_alike",
    "is_same_mesh",
    "is_same_place",
    "is_same_size",
    "may_be_bent",
    "principal_motions",
    "surface_difference",
]

# Tolerances, relative to √area or to the measure itself.
_FINE = 1e-5
# An edge that is longer by a tenth of the shortest wavelength changes its spectrum by this.
_SPECTRAL = 0.6
# Error of coordinates that files with six digits have, on average over the vertices.
_COORDINATE = 1e-7
# Least chirality of a mesh that is not its own mirror image.
_CHIRAL = 1e-4
_NOISE = 4.0
# Largest error of a moment, in units of both shapes' coarseness. Between other triangulations of one surface
# it is up to 1.2, between poses 1.6 and more (docs/measurements/evidence.md).
_COARSE = 1.6
# Moments that differ by less are those of two rigid shapes of almost the same sizes.
_NEARLY_EQUAL = 0.025
# Largest share of curved surface of a flat-sided part.
_FLAT_SIDED = 0.1
# Share of edges that change their length at the joints of a flat-sided shape.
_CHANGED_EDGES = 0.05


def is_same_mesh(first: MeshMeasures, second: MeshMeasures) -> bool:
    """Decide whether one mesh is a copy of another, but for place, size and mirroring.

    Parameters
    ----------
    first, second : MeshMeasures

    Returns
    -------
    same : bool
        Also False where the coordinates are too coarse to tell, such as those of a small part far from the
        origin.
    """
    if (first.vertex_count, first.face_count) != (second.vertex_count, second.face_count):
        return False
    rounding = first.rounding + second.rounding
    if np.abs(first.moments - second.moments).max() > _FINE + 8 * rounding:
        return False
    return _are_equal(first.spectra, second.spectra, rounding, 3 * first.face_count or first.vertex_count)


def _are_equal(first: FloatArray, second: FloatArray, rounding: float, count: int) -> bool:
    """Decide whether two spectra are those of the same lengths, as far as their number allows to tell."""
    # Rounding errors of the lengths add up like a random walk.
    noise = _NOISE * 2 * np.pi * rounding / WAVELENGTHS * np.sqrt(count)
    usable = noise < np.sqrt(count) / 2
    difference = np.abs(first - second).reshape(2, -1)
    return bool(usable[:1].all() and (difference[:, usable] <= (_SPECTRAL + noise)[usable]).all())


def is_same_place(first: MeshMeasures, second: MeshMeasures) -> bool:
    """Decide whether two copies of a mesh have the same size and place.

    Parameters
    ----------
    first, second : MeshMeasures
        For which `is_same_mesh` holds.

    Returns
    -------
    same : bool
    """
    if first.hash == second.hash != 0:
        return True
    rounding = first.rounding + second.rounding
    apart = np.abs(first.center - second.center).max() / first.unit
    turned = max(
        np.abs(getattr(first, name) - getattr(second, name)).max() for name in ("second", "normals", "cubic")
    )
    if not is_same_size(first, second) or max(apart, turned) > _FINE + 4 * rounding:
        return False
    if np.isnan(first.corners + second.corners).any():
        # Without spectra only axes that can be told apart show that nothing was turned.
        return principal_axes(full(first.second)) is not None
    return _are_equal(first.corners, second.corners, rounding, 3 * first.face_count or first.vertex_count)


def is_same_size(first: MeshMeasures, second: MeshMeasures) -> bool:
    """Decide whether two copies of a mesh have the same size.

    Parameters
    ----------
    first, second : MeshMeasures

    Returns
    -------
    same : bool
    """
    return abs(second.unit / first.unit - 1) <= _FINE + 4 * (first.rounding + second.rounding)


def handed_alike(first: MeshMeasures, second: MeshMeasures) -> bool | None:
    """Decide whether two shapes with the same moments are mirror images.

    Parameters
    ----------
    first, second : MeshMeasures

    Returns
    -------
    alike : bool or None
        False if one is the mirror image of the other; None if the moments are those of a surface that is its
        own mirror image, and so are the triangles if both have the same.
    """
    (own, own_error), (other, other_error) = first.handedness.T, second.handedness.T
    noise = np.maximum(own_error, other_error) * (_COORDINATE + first.rounding + second.rounding)
    if not is_same_mesh(first, second):
        noise += 3 * (first.coarseness + second.coarseness)
    alike, unlike = np.abs(own - other), np.abs(own + other)
    certain = np.flatnonzero(np.maximum(alike, unlike) > noise)
    certain = certain[np.minimum(alike, unlike)[certain] < 0.1 * np.maximum(alike, unlike)[certain]]
    if len(certain) == 0:
        return _chiral_alike(first, second) if is_same_mesh(first, second) else None
    largest = certain[(np.maximum(alike, unlike) / noise)[certain].argmax()]
    return bool(alike[largest] < unlike[largest])


def _chiral_alike(first: MeshMeasures, second: MeshMeasures) -> bool | None:
    """Decide whether two meshes of the same triangles are mirror images, where their moments do not tell.

    A small engraving on a square plate does not change the moments enough.
    """
    alike, unlike = abs(first.chirality - second.chirality), abs(first.chirality + second.chirality)
    if max(alike, unlike) < _CHIRAL or min(alike, unlike) > 0.1 * max(alike, unlike):
        return None
    return alike < unlike


def are_flat_sided(first: MeshMeasures, second: MeshMeasures) -> bool:
    """Decide whether both shapes are flat-sided parts, such as a plate or a bracket.

    Parameters
    ----------
    first, second : MeshMeasures

    Returns
    -------
    flat : bool
    """
    return max(first.curved, second.curved) <= _FLAT_SIDED


def may_be_bent(first: MeshMeasures, second: MeshMeasures) -> bool:
    """Decide whether one shape may be the other in another pose.

    Flat-sided parts do not bend. Those with joints keep most of their edges.

    Parameters
    ----------
    first, second : MeshMeasures
        For which `is_same_mesh` does not hold.

    Returns
    -------
    may : bool
        False for two flat-sided parts of other sizes, and for surfaces whose moments are almost equal.
    """
    difference, tolerance = surface_difference(first, second)
    if tolerance < difference < _NEARLY_EQUAL:
        return False
    if not are_flat_sided(first, second):
        return True
    if (first.vertex_count, first.face_count) != (second.vertex_count, second.face_count):
        return False
    longest = [0, len(first.spectra) // 2]  # cosine and sine of the longest wavelength
    away = np.abs(first.spectra - second.spectra)[longest].max()
    return bool(away <= _CHANGED_EDGES * 3 * first.face_count)


def principal_motions(
    first: MeshMeasures, second: MeshMeasures, *, reflected: bool = False
) -> list[tuple[float, FloatArray, FloatArray]]:
    """Find the motions x ↦ s R x + t that bring the principal axes of the second onto those of the first.

    Parameters
    ----------
    first, second : MeshMeasures
    reflected : bool, optional
        Whether R is to be a reflection.

    Returns
    -------
    motions : list of (float, (3, 3) array, (3,) array)
        s, R and t: four, because axes have no sign; none where two axes are hard to tell apart.
    """
    found, other_found = (principal_axes(full(measures.second)) for measures in (first, second))
    if found is None or other_found is None:
        return []
    (_, axes), (_, other_axes) = found, other_found
    scale = first.unit / second.unit
    motions = []
    for signs in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)):
        turn = axes @ np.diag(signs) @ other_axes.T
        if (np.linalg.det(turn) < 0) != reflected:
            turn = -turn
        motions.append((scale, turn, first.center - scale * turn @ second.center))
    return motions


def surface_difference(first: MeshMeasures, second: MeshMeasures) -> tuple[float, float]:
    """Compare two surfaces by their moments, whatever their triangles, places and sizes.

    Parameters
    ----------
    first, second : MeshMeasures

    Returns
    -------
    difference : float
        Largest difference of a moment; those of the points relative to themselves.
    tolerance : float
        Difference that two triangulations of one surface may have.
    """
    scale = np.concatenate(
        [np.maximum(first.moments[:3], 1e-3), np.ones(3), np.maximum(first.moments[6:], 1e-3)]
    )
    difference = np.abs(first.moments - second.moments) / scale
    rounding = 8 * (first.rounding + second.rounding)
    return float(difference.max()), _FINE + rounding + _COARSE * (first.coarseness + second.coarseness)
