# SPDX-License-Identifier: MIT
"""Are keypoints found again on a transformed shape? As in the track of SHREC 2010 on feature detection.

A point of a transformed shape is repeated if one was found on the null shape within a small distance, along
the null shape, of the place that it came from (Bronstein et al., SHREC 2010: robust feature detection and
description benchmark). Who marks every vertex finds all of them again: what the same number of points would
have had by chance is told beside it.
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
from shapegoogle_core.correspondence.distance_graph import distance_graph
from shapegoogle_core.keypoints import DETECTORS, detect_keypoints
from shapegoogle_core.laplacian import cotangent
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ModelSettings
from shapegoogle_core.model.augmentation import scale_factor
from shapegoogle_core.model.working_shape import working_shape

__all__ = ["TOLERANCE", "NullShape", "Repeatability", "found_points", "places_on_null", "repeatability"]

TOLERANCE = 0.03
"""How far off a point may be found again, as a share of the null shape's diameter along its surface."""

# From corner to corner: the first steps find most of the diameter, further ones hardly add to it.
_SWEEPS = 4

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Repeatability:
    """How many points of one shape were found again on another.

    Attributes
    ----------
    points : int
        Found on the transformed shape.
    repeated : float
        Share of them that come from within the tolerance of a point of the null shape; NaN if there are none.
    chance : float
        Share of the null shape's area that is within the tolerance of one of its points: what points thrown
        at random would reach.
    """

    points: int
    repeated: float
    chance: float


class NullShape:
    """A shape before it is transformed, and distances along it.

    Parameters
    ----------
    mesh : Mesh
        Repaired.
    """

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self._graph: sparse.csr_array = distance_graph(mesh, np.empty((0, 2), np.int64), np.empty(0))
        self.diameter = self._diameter()

    def _diameter(self) -> float:
        """Largest distance along the largest part, between vertices."""
        _, part = connected_components(self._graph, directed=False)
        here, diameter = int(np.argmax(part == np.bincount(part).argmax())), 0.0
        for _ in range(_SWEEPS):
            along = dijkstra(self._graph, directed=False, indices=[here])[0]
            along[~np.isfinite(along)] = 0
            here = int(along.argmax())
            diameter = max(diameter, float(along[here]))
        return diameter

    def near(self, vertices: Indices, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
        """Mask of the vertices within the tolerance of any of some vertices."""
        if len(vertices) == 0:
            return np.zeros(len(self.mesh.vertices), bool)
        limit = tolerance * self.diameter
        along = dijkstra(self._graph, directed=False, indices=vertices, min_only=True, limit=limit)
        within: NDArray[np.bool_] = np.isfinite(along)
        return within


def places_on_null(null: Mesh, query: Mesh, kind: str, strength: int, points: FloatArray) -> Indices:
    """Tell from where on a null shape points of a transformed one came.

    Transformations that keep all vertices keep their order: vertex i came from vertex i. The others leave
    what remains in its place, but for the size and, in "mixed", noise of less than an edge: there it is what
    is nearest. A welded pair of vertices came from either.

    Parameters
    ----------
    null : Mesh
        What was transformed.
    query : Mesh
        What `transform` made of it, or another pose with the same vertices.
    kind : str
        One of `TRANSFORMATIONS`, or "isometry".
    strength : int
    points : (p, 3) array
        On the query, in its place and unit.

    Returns
    -------
    vertices : (p,) array of int
        Of the null shape.

    Raises
    ------
    ValueError
        If the kind is "isometry" and the vertices are not the same.
    """
    _, nearest = KDTree(query.vertices).query(points)
    if len(query.vertices) == len(null.vertices):
        return np.asarray(nearest, np.int64)
    if kind == ISOMETRY:
        raise ValueError(
            f"{query.name!r} has not the vertices of {null.name!r}: nobody knows where its points came from"
        )
    _, origin = KDTree(null.vertices).query(query.vertices[nearest] / scale_factor(kind, strength))
    return np.asarray(origin, np.int64)


def found_points(
    settings: ModelSettings, mesh: Mesh, detectors: Mapping[str, Mapping[str, float]] | None = None
) -> dict[str, FloatArray]:
    """Find keypoints of a mesh as a model prepares it.

    Parameters
    ----------
    settings : ModelSettings
        Only preprocessing, area, Laplacian and eigenpairs matter.
    mesh : Mesh
    detectors : mapping of str to mapping, optional
        Names of `DETECTORS` and parameters of each; left out, all as they are.

    Returns
    -------
    points : dict of str to (p, 3) array
        By detector, in the place and unit of the mesh as given, the strongest first.
    """
    shape = working_shape(settings, mesh)
    vertices = shape.placement.restore(shape.mesh).vertices
    chosen = {name: {} for name in DETECTORS} if detectors is None else detectors
    return {
        name: vertices[detect_keypoints(shape.mesh, shape.spectrum, name, **parameters).indices]
        for name, parameters in chosen.items()
    }


def repeatability(null: NullShape, null_points: FloatArray, places: Indices) -> Repeatability:
    """Count the points that are found again.

    Parameters
    ----------
    null : NullShape
    null_points : (q, 3) array
        Keypoints of the null shape.
    places : (p,) array of int
        Where the keypoints of the transformed shape came from, see `places_on_null`.

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
