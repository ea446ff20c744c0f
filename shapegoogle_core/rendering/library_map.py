# SPDX-License-Identifier: MIT
"""Map of a library: its shapes in the plane, those that are alike near each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shapegoogle_core.library.library import Library
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["MOST_SHAPES", "MapPoint", "lay_out"]

MOST_SHAPES = 2_000
"""Shapes on a map; of a larger library evenly chosen ones."""

_FIRST_SPREAD = 1e-4
_PERPLEXITY = 20.0
# With fewer shapes there are too few neighbours for an embedding that looks at neighbours.
_FEW = 8


@dataclass(frozen=True)
class MapPoint:
    """A shape on the map.

    Attributes
    ----------
    shape_id : int
    name : str
    x, y : float
        From 0 to 1.
    """

    shape_id: int
    name: str
    x: float
    y: float


def lay_out(library: Library, most: int = MOST_SHAPES) -> tuple[int, list[MapPoint]]:
    """Lay the shapes of a library out in the plane.

    The distances are those that lists of matches are sorted by. Classical scaling gives the first places, and
    t-SNE (van der Maaten and Hinton 2008), which keeps neighbours together, the last ones. Only which shapes
    are near each other means something, not how far apart the others are.

    Parameters
    ----------
    library : Library
    most : int, optional
        Maximum number of shapes.

    Returns
    -------
    total : int
        Number of shapes in the library.
    points : list of MapPoint

    Examples
    --------
    >>> import tempfile, trimesh
    >>> import shapegoogle_core as sg
    >>> from shapegoogle_core.rendering.library_map import lay_out
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
    ...         for size in (1, 2):
    ...             _ = library.add(trimesh.creation.box((1, 1, size)), name=f"box {size}")
    ...         total, points = lay_out(library)
    >>> total, [point.name for point in points]
    (2, ['box 1', 'box 2'])
    """
    shapes = [(shape.shape_id, shape.object_name or shape.name) for shape in library.shapes()]
    total = len(shapes)
    if total > most:
        shapes = [shapes[index] for index in np.linspace(0, total - 1, most).astype(int)]
    if not shapes:
        return 0, []
    names = dict(shapes)
    numbers, distances = library.distances_among(list(names))
    return total, [
        MapPoint(shape_id, names[shape_id], round(float(x), 4), round(float(y), 4))
        for shape_id, (x, y) in zip(numbers, _places(distances), strict=True)
    ]


def _places(distances: FloatArray) -> FloatArray:
    """Find points of the unit square whose distances are similar."""
    from sklearn.manifold import TSNE

    count = len(distances)
    plane = _scaled(distances) if count > 1 else np.zeros((count, 2))
    if count >= _FEW and plane.any():
        perplexity = min(_PERPLEXITY, (count - 1) / 3)
        # As small as t-SNE wants its first places, so that they do not hold it back.
        first = _FIRST_SPREAD * plane / plane.std()
        embedding = TSNE(perplexity=perplexity, metric="precomputed", init=first, random_state=0)
        plane = embedding.fit_transform(distances).astype(np.float64)
    if not count:
        return plane
    low, extent = plane.min(axis=0), np.ptp(plane, axis=0)
    return np.asarray((plane - low) / np.where(extent > 0, extent, 1))


def _scaled(distances: FloatArray) -> FloatArray:
    """Classical multidimensional scaling: the plane whose inner products are nearest to the distances."""
    from scipy.linalg import eigh

    squared = distances**2
    centred = squared - squared.mean(axis=0) - squared.mean(axis=1)[:, None] + squared.mean()
    count = len(distances)
    values, vectors = eigh(-centred / 2, subset_by_index=[count - 2, count - 1])
    return np.asarray(vectors[:, ::-1] * np.sqrt(np.maximum(values[::-1], 0)))
