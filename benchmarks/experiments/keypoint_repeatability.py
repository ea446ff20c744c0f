# SPDX-License-Identifier: MIT
"""Repeatability of keypoints under transformations, as in the feature detection track of SHREC 2010.

A keypoint of a transformed shape is repeated if a keypoint of the null shape lies within a small distance,
measured along the null shape, of the point's origin (Bronstein et al., SHREC 2010: robust feature detection
and description benchmark). A detector that returns every vertex repeats all of them, so repeatability is
reported together with that of random points.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree

from benchmarks.protocol.collection import ISOMETRY
from shapegoogle_core.descriptors.geodesics import surface_graph
from shapegoogle_core.keypoints import DETECTORS, detect_keypoints
from shapegoogle_core.laplacian import cotangent
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ModelSettings
from shapegoogle_core.model.augmentation import scale_factor
from shapegoogle_core.model.working_shape import working_shape

__all__ = ["TOLERANCE", "NullShape", "Repeatability", "found_points", "places_on_null", "repeatability"]

TOLERANCE = 0.03
"""Largest distance of a repeated point, as a share of the null shape's diameter along its surface."""

# Each sweep starts at the end of the one before; further sweeps hardly increase the diameter.
_SWEEPS = 4

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Repeatability:
    """Repeatability of the keypoints of a transformed shape.

    Attributes
    ----------
    points : int
        Number of keypoints of the transformed shape.
    repeated : float
        Share of them whose origin is within the tolerance of a keypoint of the null shape; NaN without
        points.
    chance : float
        Share of the null shape's area within the tolerance of one of its keypoints, which is the
        repeatability of random points.
    """

    points: int
    repeated: float
    chance: float


class NullShape:
    """A null shape and distances along it.

    Parameters
    ----------
    mesh : Mesh
        Repaired.
    """

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self._graph: sparse.csr_array = surface_graph(mesh)
        self.diameter = self._diameter()

    def _diameter(self) -> float:
        """Compute the largest distance between vertices along the largest part."""
        _, part = connected_components(self._graph, directed=False)
        here, diameter = int(np.argmax(part == np.bincount(part).argmax())), 0.0
        for _ in range(_SWEEPS):
            along = dijkstra(self._graph, directed=False, indices=[here])[0]
            along[~np.isfinite(along)] = 0
            here = int(along.argmax())
            diameter = max(diameter, float(along[here]))
        return diameter

    def near(self, vertices: Indices, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
        """Return the mask of vertices within the tolerance of any of some vertices.

        Parameters
        ----------
        vertices : (v,) array of int
        tolerance : float
            As a share of the diameter.

        Returns
        -------
        near : (n,) array of bool
        """
        if len(vertices) == 0:
            return np.zeros(len(self.mesh.vertices), bool)
        limit = tolerance * self.diameter
        along = dijkstra(self._graph, directed=False, indices=vertices, min_only=True, limit=limit)
        within: NDArray[np.bool_] = np.isfinite(along)
        return within


def places_on_null(null: Mesh, query: Mesh, kind: str, strength: int, points: FloatArray) -> Indices:
    """Find the origins, on a null shape, of points of a transformed shape.

    Transformations that keep the number of vertices also keep their order, so vertex i originates from vertex
    i. The others keep the positions of the remaining vertices, except for scale and, in "mixed", noise of
    less than an edge length, so the origin is the nearest vertex. A welded pair originates from either one.

    Parameters
    ----------
    null : Mesh
        The shape before the transformation.
    query : Mesh
        Result of `transform`, or another pose with the same vertices.
    kind : str
        One of `TRANSFORMATIONS`, or "isometry".
    strength : int
    points : (p, 3) array
        Points on the query, in its position and unit.

    Returns
    -------
    vertices : (p,) array of int
        Of the null shape.

    Raises
    ------
    ValueError
        If the kind is "isometry" and the numbers of vertices differ.
    """
    _, nearest = KDTree(query.vertices).query(points)
    if len(query.vertices) == len(null.vertices):
        return np.asarray(nearest, np.int64)
    if kind == ISOMETRY:
        raise ValueError(
            f"{query.name!r} does not have the vertices of {null.name!r}, so its points have no known origin"
        )
    _, origin = KDTree(null.vertices).query(query.vertices[nearest] / scale_factor(kind, strength))
    return np.asarray(origin, np.int64)


def found_points(
    settings: ModelSettings, mesh: Mesh, detectors: Mapping[str, Mapping[str, float]] | None = None
) -> dict[str, FloatArray]:
    """Detect keypoints of a mesh preprocessed for a model.

    Parameters
    ----------
    settings : ModelSettings
        Only preprocessing, area, Laplacian and eigenpairs matter.
    mesh : Mesh
    detectors : mapping of str to mapping, optional
        Names of `DETECTORS` and their parameters; default: all with their default parameters.

    Returns
    -------
    points : dict of str to (p, 3) array
        By detector, in the position and unit of the given mesh, the strongest first.
    """
    shape = working_shape(settings, mesh)
    vertices = shape.placement.restore(shape.mesh).vertices
    chosen = {name: {} for name in DETECTORS} if detectors is None else detectors
    return {
        name: vertices[detect_keypoints(shape.mesh, shape.spectrum, name, **parameters).indices]
        for name, parameters in chosen.items()
    }


def repeatability(null: NullShape, null_points: FloatArray, places: Indices) -> Repeatability:
    """Compute the repeatability of keypoints.

    Parameters
    ----------
    null : NullShape
    null_points : (q, 3) array
        Keypoints of the null shape.
    places : (p,) array of int
        Origins of the keypoints of the transformed shape, see `places_on_null`.

    Returns
    -------
    measured : Repeatability
    """
    _, vertices = KDTree(null.mesh.vertices).query(null_points) if len(null_points) else (0, np.empty(0, int))
    near = null.near(np.asarray(vertices, np.int64))
    areas = cotangent(null.mesh).lumped_mass
    return Repeatability(
        points=len(places),
        repeated=float(near[places].mean()) if len(places) else float("nan"),
        chance=float(areas[near].sum() / areas.sum()),
    )
