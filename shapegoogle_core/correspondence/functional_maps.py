# SPDX-License-Identifier: MIT
"""Functional maps and their refinement by spectral upsampling.

References
----------
M. Ovsjanikov, M. Ben-Chen, J. Solomon, A. Butscher, L. Guibas: Functional Maps: A Flexible Representation of
Maps Between Shapes. ACM Transactions on Graphics 31(4), 2012.
S. Melzi, J. Ren, E. Rodolà, A. Sharma, P. Wonka, M. Ovsjanikov: ZoomOut: Spectral Upsampling for Efficient
Shape Correspondence. ACM Transactions on Graphics 38(6), 2019.
D. Ezuz, M. Ben-Chen: Deblurring and Denoising of Maps between Shapes. Computer Graphics Forum 36(5), 2017.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray, IntArray

__all__ = ["FunctionalMaps", "PointMaps", "nearest", "nearest_in_faces", "project", "zoom_out"]

Indices = NDArray[np.int64]

_AT_ONCE = 2_000_000  # entries of a matrix of distances


@dataclass(frozen=True, eq=False)
class PointMaps:
    """Map from the points of a shape a to those of a shape b, and one back.

    Attributes
    ----------
    forth : (p,) array of int
        Point of b for each point of a.
    back : (q,) array of int
        Point of a for each point of b.
    """

    forth: Indices
    back: Indices


@dataclass(frozen=True, eq=False)
class FunctionalMaps:
    """Functional maps in both directions, in the bases of eigenfunctions.

    Attributes
    ----------
    to_a : (k, k) array
        C with coefficients on a = C · coefficients on b: it pulls functions back along the map from a to b.
    to_b : (k, k) array
        The same for the map from b to a.
    """

    to_a: FloatArray
    to_b: FloatArray

    def embed_a(self, functions: FloatArray) -> FloatArray:
        """Embed points of a in the space in which nearest points of b are their images.

        Parameters
        ----------
        functions : (p, k) array
            Eigenfunctions φ of a at p points.

        Returns
        -------
        places : (p, 2k) array
            [φ, φ to_bᵀ], where φ to_bᵀ at x equals the eigenfunctions of b at the point that is mapped to x.
        """
        k = len(self.to_a)
        return np.concatenate([functions[:, :k], functions[:, :k] @ self.to_b.T], axis=1)

    def embed_b(self, functions: FloatArray) -> FloatArray:
        """Embed points of b in the same space; see `embed_a`.

        Parameters
        ----------
        functions : (q, k) array
            Eigenfunctions of b at q points.

        Returns
        -------
        places : (q, 2k) array
        """
        k = len(self.to_a)
        return np.concatenate([functions[:, :k] @ self.to_a.T, functions[:, :k]], axis=1)


def nearest(queries: FloatArray, targets: FloatArray) -> Indices:
    """Find the nearest target of each point, in any dimension.

    Parameters
    ----------
    queries : (p, d) array
    targets : (q, d) array

    Returns
    -------
    index : (p,) array of int
        Row of `targets` for each row of `queries`.
    """
    queries, targets = queries.astype(np.float32), targets.astype(np.float32)
    half_squares = 0.5 * (targets**2).sum(axis=1)
    step = max(1, _AT_ONCE // len(targets))
    return np.concatenate(
        [
            (half_squares - queries[start : start + step] @ targets.T).argmin(axis=1)
            for start in range(0, len(queries), step)
        ]
    )


def project(functions_a: FloatArray, functions_b: FloatArray, maps: PointMaps, k: int) -> FunctionalMaps:
    """Fit functional maps of size k to point maps, by least squares (Melzi et al., equation 1).

    Parameters
    ----------
    functions_a : (p, ≥ k) array
        Eigenfunctions of a at p points.
    functions_b : (q, ≥ k) array
        Eigenfunctions of b at q points.
    maps : PointMaps
        Maps between these points.
    k : int

    Returns
    -------
    maps : FunctionalMaps
    """
    a, b = functions_a[:, :k], functions_b[:, :k]
    return FunctionalMaps(_fit(a, b[maps.forth]), _fit(b, a[maps.back]))


def _fit(basis: FloatArray, values: FloatArray) -> FloatArray:
    gram = basis.T @ basis
    gram[np.diag_indices(len(gram))] += 1e-9 * np.trace(gram) / len(gram)  # fewer points than functions
    return np.asarray(np.linalg.solve(gram, basis.T @ values), np.float64)


def zoom_out(
    functions_a: FloatArray, functions_b: FloatArray, maps: PointMaps, sizes: Sequence[int]
) -> PointMaps:
    """Refine point maps by functional maps of increasing size, in both directions at once.

    Each step fits functional maps and maps each point to the nearest one in both embeddings together, so that
    the two directions agree (as in MapTree, Ren et al. 2020).

    Parameters
    ----------
    functions_a : (p, k) array
        Eigenfunctions of a at p points.
    functions_b : (q, k) array
        Eigenfunctions of b at q points.
    maps : PointMaps
        Maps between these points.
    sizes : sequence of int
        Size of the functional maps in each step.

    Returns
    -------
    maps : PointMaps
    """
    for k in sizes:
        fitted = project(functions_a, functions_b, maps, min(k, functions_a.shape[1], functions_b.shape[1]))
        places_a = fitted.embed_a(functions_a).astype(np.float32)
        places_b = fitted.embed_b(functions_b).astype(np.float32)
        products = places_a @ places_b.T
        forth = (0.5 * (places_b**2).sum(axis=1) - products).argmin(axis=1)
        back = (0.5 * (places_a**2).sum(axis=1)[:, None] - products).argmin(axis=0)
        maps = PointMaps(forth, back)
    return maps


def nearest_in_faces(queries: FloatArray, places: FloatArray, faces: IntArray) -> tuple[Indices, FloatArray]:
    """Find the nearest point on the faces around the nearest vertex (Ezuz and Ben-Chen 2017).

    Parameters
    ----------
    queries : (p, d) array
    places : (n, d) array
        Positions of the vertices.
    faces : (m, 3) array of int
        Every vertex must belong to a face.

    Returns
    -------
    face : (p,) array of int
    weights : (p, 3) array
        Barycentric coordinates of the nearest points: rows are ≥ 0 and sum to 1.
    """
    vertex = nearest(queries, places)
    order = np.argsort(faces.ravel(), kind="stable")
    valence = np.bincount(faces.ravel(), minlength=len(places))
    first = np.cumsum(valence) - valence
    gram, duals = _face_frames(places, faces)
    face, weights = np.empty(len(queries), np.int64), np.empty((len(queries), 3))
    step = max(1, _AT_ONCE // (10 * places.shape[1]))
    for start in range(0, len(queries), step):
        part = slice(start, start + step)
        counts = valence[vertex[part]]
        owner = np.repeat(np.arange(len(counts)), counts)
        local = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
        candidate = order[first[vertex[part]][owner] + local] // 3
        offset = queries[part][owner] - places[faces[candidate, 0]]
        products = np.einsum("cid,cd->ci", duals[candidate], offset)
        shares = _clamped(gram[candidate], products)
        # ‖offset - Σ w_i side_i‖². All candidates meet in one vertex, so no small difference of large numbers
        # arises.
        fit = np.einsum("ci,cij,cj->c", shares, gram[candidate], shares) - 2 * (shares * products).sum(axis=1)
        squared = (offset**2).sum(axis=1) + fit
        best = np.lexsort([squared, owner])[np.cumsum(counts) - counts]
        face[part] = candidate[best]
        weights[part] = np.column_stack([1 - shares[best].sum(axis=1), shares[best]])
    return face, weights


def _face_frames(places: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the products (m, 2, 2) of the two sides at the first corner, and these sides (m, 2, d)."""
    sides = places[faces[:, 1:]] - places[faces[:, :1]]
    return np.einsum("fid,fjd->fij", sides, sides), sides


def _clamped(gram: FloatArray, products: FloatArray) -> FloatArray:
    """Return weights (c, 2) of the second and third corner at the nearest point of each triangle.

    It is the projection if that lies inside, else the nearest point on the three sides.
    """
    g00, g01, g11 = gram[:, 0, 0], gram[:, 0, 1], gram[:, 1, 1]
    tiny = np.finfo(float).tiny
    determinant = g00 * g11 - g01**2
    safe = np.where(determinant > 1e-12 * g00 * g11, determinant, np.inf)
    inner = (
        np.stack(
            [g11 * products[:, 0] - g01 * products[:, 1], g00 * products[:, 1] - g01 * products[:, 0]], axis=1
        )
        / np.maximum(safe, tiny)[:, None]
    )
    second = np.clip(products[:, 0] / np.maximum(g00, tiny), 0, 1)
    third = np.clip(products[:, 1] / np.maximum(g11, tiny), 0, 1)
    # On the side from the second to the third corner: (1 - t, t).
    length = g00 - 2 * g01 + g11
    t = np.clip((products[:, 1] - products[:, 0] + g00 - g01) / np.maximum(length, tiny), 0, 1)
    zero = np.zeros(len(t))
    options = np.stack(
        [np.stack([second, zero], 1), np.stack([zero, third], 1), np.stack([1 - t, t], 1)], axis=1
    )
    squared = np.einsum("coi,cij,coj->co", options, gram, options) - 2 * np.einsum(
        "coi,ci->co", options, products
    )
    edge = options[np.arange(len(options)), squared.argmin(axis=1)]
    inside = (inner >= 0).all(axis=1) & (inner.sum(axis=1) <= 1) & np.isfinite(safe)
    return np.where(inside[:, None], inner, edge)
