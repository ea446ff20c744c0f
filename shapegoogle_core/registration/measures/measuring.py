# SPDX-License-Identifier: MIT
"""From a mesh to its measures: sums over all its triangles, corners and edges."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.connectivity import shared_sides, used_points
from shapegoogle_core.mesh.measures import bounding_box, dots, face_normals
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh
from shapegoogle_core.mesh.places import first_at_place, hashed_rows
from shapegoogle_core.registration.measures.mesh_measures import ROUNDING, WAVELENGTHS, MeshMeasures
from shapegoogle_core.registration.measures.moments import surface_moments, upper

__all__ = ["measure_mesh"]

# Edges with a smaller angle between their faces belong to a curved surface, others are meant to be sharp.
_SHARPEST = np.radians(40)
# ... and those with a smaller one to a flat side, but for rounding.
_FLATTEST = 1e-3
# Sums of products below this are those of rounding errors.
_LEAST_PRODUCT = 1e-6
# Directions of the spectra of corners, one for each wavelength: of unit length, and along no edge of a box.
_ALONG = np.array([[0.62, 0.35, 0.70], [-0.41, 0.87, 0.27], [0.53, -0.29, 0.80]])
_ALONG /= np.linalg.norm(_ALONG, axis=1, keepdims=True)
# Triangles, and edges, that are measured at once: what is computed for them fits into the processor's cache.
_TRIANGLES_AT_ONCE, _EDGES_AT_ONCE = 1 << 11, 1 << 14


def measure_mesh(mesh: Mesh) -> MeshMeasures | None:
    """Measure a mesh.

    Parameters
    ----------
    mesh : Mesh
        As it was read; a point cloud is measured by its points.

    Returns
    -------
    measures : MeshMeasures or None
        None if it has no area, or a cloud no extent.
    """
    vertices, count = mesh.vertices, len(mesh.vertices)
    if count == 0:
        return None
    # A point of a cloud is measured as a face of one corner.
    faces = np.arange(count, dtype=np.int32)[:, None] if mesh.is_point_cloud else mesh.faces
    low, high = bounding_box(used_points(vertices, mesh.faces))
    if mesh.is_point_cloud:
        area = float(((high - low) ** 2).sum())
        normals, areas = np.zeros((count, 3)), np.full(count, area / count)
    else:
        normals, areas = face_normals(mesh)
        area = float(areas.sum())
    if not area > 0:
        return None
    unit, origin, weights = np.sqrt(area), (low + high) / 2, areas / area
    relative = np.ascontiguousarray(((vertices - origin) / unit).T)
    corner_weights = np.repeat(weights / faces.shape[1], faces.shape[1])
    mean = relative @ np.bincount(faces.ravel(), corner_weights, count)
    relative -= mean[:, None]
    if mesh.is_point_cloud:
        coarseness, curved = np.inf, 1.0
        spectra, chirality = _length_spectrum(_nearest(vertices) / unit), 0.0
    else:
        coarseness, curved = _bending(mesh, normals, areas)
        spectra, chirality = _side_sums(relative, faces)
    moments = surface_moments(relative, faces, normals, weights)
    return MeshMeasures(
        count,
        len(mesh.faces),
        _hash(mesh),
        area,
        float(max(np.abs(low).max(), np.abs(high).max()) / unit * ROUNDING),
        coarseness,
        curved,
        origin + unit * mean,
        moments.second,
        upper((weights * normals.T) @ normals),
        moments.cubic,
        moments.twist,
        moments.swirl,
        moments.fourth,
        moments.support,
        chirality,
        spectra,
        _corner_spectrum(relative, faces),
    )


def _nearest(points: FloatArray) -> FloatArray:
    """Distance of each point to the nearest other one; 0 for a single point."""
    distances, _ = cKDTree(points).query(points, min(2, len(points)))
    return np.asarray(distances, np.float64).reshape(len(points), -1)[:, -1]


def _side_sums(relative: FloatArray, faces: IntArray) -> tuple[FloatArray, float]:
    """Compute the spectra of the sides of all triangles, and their chirality.

    Chirality compares the right-handed triangles of a mesh with the left-handed ones. A triangle counts with
    the determinant of its corners, in the order of their distances from the centre: Σ q / Σ |q| with q =
    det(a, b, c) (|a| − |b|)(|b| − |c|)(|c| − |a|), divided by all the lengths in it. It does not depend on
    the order in which a file has the corners.

    Parameters
    ----------
    relative : (3, n) array
        Coordinates of the vertices relative to the centre, in units of √area.
    faces : (m, 3) array of int

    Returns
    -------
    spectra : (2 w,) array
    chirality : float
        Its negative for the mirror image; 0 for a mesh that is its own mirror image.
    """
    spectra = np.zeros(2 * len(WAVELENGTHS))
    handed = total = 0.0
    for start in range(0, len(faces), _TRIANGLES_AT_ONCE):
        corners = relative.take(faces[start : start + _TRIANGLES_AT_ONCE].T, axis=1)
        sides = np.sqrt(((corners - corners[:, [1, 2, 0]]) ** 2).sum(axis=0))
        spectra += _length_spectrum(sides)
        products = _handed_products(corners, sides)
        handed += float(products.sum())
        total += float(np.abs(products).sum())
    return spectra, handed / total if total > _LEAST_PRODUCT else 0.0


def _handed_products(corners: FloatArray, sides: FloatArray) -> FloatArray:
    """Compute q of each triangle, see `_side_sums`, from corners (3, 3, m) and lengths of sides (3, m)."""
    away = np.sqrt((corners**2).sum(axis=0))
    lengths = np.prod(away * sides, axis=0)
    (a, b, c), (d, e, f), (g, h, i) = corners
    determinants = a * (e * i - f * h) + d * (h * c - b * i) + g * (b * f - e * c)
    products = determinants * np.prod(away - away[[1, 2, 0]], axis=0)
    return np.asarray(products / np.where(lengths > 0, lengths, 1))


def _length_spectrum(lengths: FloatArray) -> FloatArray:
    """Sum the cosines of lengths in units of √area for each wavelength, and their sines."""
    phase = 2 * np.pi / WAVELENGTHS[0] * lengths
    cosine, sine = np.cos(phase), np.sin(phase)
    sums = [(cosine.sum(), sine.sum())]
    for _ in WAVELENGTHS[1:]:
        for _ in range(2):  # a quarter of the wavelength: four times the angle
            cosine, sine = cosine * cosine - sine * sine, 2 * cosine * sine
        sums.append((cosine.sum(), sine.sum()))
    return np.array(sums).T.ravel()


def _corner_spectrum(relative: FloatArray, faces: IntArray) -> FloatArray:
    """Sum the cosines of the corners' coordinates along a direction for each wavelength, and their sines."""
    uses = np.bincount(faces.ravel(), minlength=relative.shape[1]).astype(np.float64)
    sums = []
    for wavelength, along in zip(WAVELENGTHS, _ALONG, strict=True):
        phase = 2 * np.pi / wavelength * along @ relative
        sums.append((uses @ np.cos(phase), uses @ np.sin(phase)))
    return np.array(sums).T.ravel()


def _bending(mesh: Mesh, normals: FloatArray, areas: FloatArray) -> tuple[float, float]:
    """Compute the coarseness of a mesh, and the share of its area that is curved; see `MeshMeasures`."""
    corners = first_at_place(mesh.vertices)[mesh.faces]
    one, other = (side // 3 for side in shared_sides(corners, len(mesh.vertices)))
    coarseness = curved = 0.0
    for start in range(0, len(one), _EDGES_AT_ONCE):
        block = slice(start, start + _EDGES_AT_ONCE)
        cosines = np.abs(dots(normals[one[block]], normals[other[block]]))
        angles = np.arccos(np.minimum(cosines, 1))
        weights = areas[one[block]] + areas[other[block]]
        weights[angles >= _SHARPEST] = 0
        coarseness += float((angles**2 @ weights) / 24)
        curved += float(weights[angles > _FLATTEST].sum() / 3)
    total = float(areas.sum())
    return coarseness / total, curved / total


def _hash(mesh: Mesh) -> int:
    """Sum of the hashes of all triangles; their order, their first corners and orientations do not matter."""
    with np.errstate(over="ignore"):
        single = mesh.vertices.T.astype(np.float32, order="C") + np.float32(0)
    places = hashed_rows(single.view(np.uint32).astype(np.uint64))
    if mesh.is_point_cloud:
        return int(hashed_rows(np.stack([places] * 3)).sum())
    total = 0
    for start in range(0, len(mesh.faces), _EDGES_AT_ONCE):
        corners = places.take(mesh.faces[start : start + _EDGES_AT_ONCE].T)
        ordered = np.empty_like(corners)
        np.minimum.reduce(corners, out=ordered[0])
        np.maximum.reduce(corners, out=ordered[2])
        np.bitwise_xor.reduce([*corners, ordered[0], ordered[2]], out=ordered[1])  # the one between
        total += int(hashed_rows(ordered).sum())
    return total % 2**64
