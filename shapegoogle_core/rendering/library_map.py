# SPDX-License-Identifier: MIT
"""Map of a library: its shapes in the plane, those that are alike near each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.library import Library

__all__ = ["MOST_SHAPES", "MapPoint", "lay_out"]

MOST_SHAPES = 2_000
"""Shapes on a map; of a larger library evenly chosen ones."""

_COMPONENTS = 50
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

    The bags of the shapes, as the model compares them, are reduced by principal components, and then by t-SNE
    (van der Maaten and Hinton 2008), which keeps neighbours together. Only which shapes are near each other
    means something, not how far apart the others are.

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
    bags = np.stack([library.signature(shape_id).bags for shape_id, _ in shapes])
    places = _places(library.model.comparable(bags).astype(np.float32))
    return total, [
        MapPoint(shape_id, name, round(float(x), 4), round(float(y), 4))
        for (shape_id, name), (x, y) in zip(shapes, places, strict=True)
    ]


def _places(vectors: NDArray[np.float32]) -> NDArray[np.float64]:
    """Reduce vectors to points of the unit square."""
    from sklearn.decomposition import PCA
    from sklearn.manifold import TSNE

    count = len(vectors)
    components = min(_COMPONENTS, count, vectors.shape[1])
    reduced = PCA(components, svd_solver="full" if count < 500 else "randomized", random_state=0)
    plane = reduced.fit_transform(vectors) if count > 1 else np.zeros((1, 2))
    if count >= _FEW:
        perplexity = min(_PERPLEXITY, (count - 1) / 3)
        plane = TSNE(perplexity=perplexity, init="pca", random_state=0).fit_transform(plane)
    plane = np.pad(plane, ((0, 0), (0, max(0, 2 - plane.shape[1]))))[:, :2].astype(np.float64)
    low, extent = plane.min(axis=0), np.ptp(plane, axis=0)
    return np.asarray((plane - low) / np.where(extent > 0, extent, 1))
