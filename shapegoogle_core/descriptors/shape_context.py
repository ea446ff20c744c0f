# SPDX-License-Identifier: MIT
"""Shape contexts, histograms of the rest of a shape as seen from a point (paper, section 3.2)."""

from __future__ import annotations

import math

import numpy as np

from shapegoogle_core.descriptors.checks import check_bins, chunks
from shapegoogle_core.mesh import MeshLike, clean_surface
from shapegoogle_core.mesh.measures import vertex_areas, vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["shape_contexts"]

# Number of contexts at a time, so that all offsets from them stay in the processor's cache.
_TOGETHER = 100


def shape_contexts(
    mesh: MeshLike, inner: float = 0.05, outer: float = 1.0, shells: int = 8, elevations: int = 4
) -> FloatArray:
    """Shape context of every vertex (paper, section 3.2; Belongie, Malik, Puzicha 2002).

    A log-polar histogram of the offsets y - x to all other points of the shape. In space (Frome et al. 2004)
    there is one angle to the normal n at x, and one about the normal, which has no natural zero on a surface:
    the bins along that angle are joined, so that a rotation does not change the histogram. The first angle is
    taken without its sign, as the normals of many meshes point to either side.

    Parameters
    ----------
    mesh : MeshLike
        A mesh of triangles.
    inner, outer : float
        Radii of the smallest and of the largest sphere, as shares of the square root of the surface's area.
    shells : int
        Number of bins in ‖y - x‖. The radii of the spheres between them grow geometrically from `inner` to
        `outer`; the first shell is the inside of the first sphere, the last one includes all that is farther.
    elevations : int
        Number of equal bins in |n · (y - x)| / ‖y - x‖, which cut a sphere into zones of equal area.

    Returns
    -------
    contexts : (n, shells · elevations) array
        Share of the area of the surface in each bin. A row sums to 1 less the share of the vertex itself,
        which lies in no direction.

    Raises
    ------
    ValueError
        If there are no bins, or the radii do not ascend.
    MeshError
        If the shape is not a surface, or a vertex has no area.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> contexts = sg.shape_contexts((vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    >>> contexts.shape
    (4, 32)
    >>> contexts.sum(axis=1).round(3).tolist()  # three of the four corners
    [0.75, 0.75, 0.75, 0.75]
    """
    mesh = clean_surface(mesh)
    check_bins("shells and elevations", shells, elevations)
    if not 0 < inner < outer < math.inf:
        raise ValueError(f"the radii inner and outer must be positive and ascend, not {inner} and {outer}")
    unit = math.sqrt(mesh.area)
    points, normals, areas = mesh.vertices / unit, vertex_normals(mesh), vertex_areas(mesh) / unit**2
    # n · y for all y is one matrix product, and so is ‖y - x‖² except for the squares. Coordinates are taken
    # from the centre, as the squares of distant coordinates would drown their differences.
    points = points - areas @ points
    squares = (points**2).sum(axis=1)
    first, step = math.log(inner**2), math.log((outer / inner) ** 2) / max(shells - 1, 1)
    contexts = []
    for chunk in chunks(len(points), _TOGETHER):
        heights = np.abs(normals[chunk] @ points.T - (normals[chunk] * points[chunk]).sum(axis=1)[:, None])
        distances = squares + squares[chunk, None] - 2 * points[chunk] @ points.T
        itself = np.arange(chunk.start, chunk.stop)
        distances[np.arange(len(itself)), itself] = 0
        apart = distances > 0
        np.maximum(distances, np.finfo(float).tiny, out=distances)
        shell = np.clip(np.ceil((np.log(distances) - first) / step), 0, shells - 1).astype(np.int32)
        elevation = np.minimum(heights / np.sqrt(distances) * elevations, elevations - 1).astype(np.int32)
        row = np.arange(len(itself), dtype=np.int32)[:, None]
        cell = (row * shells + shell) * elevations + elevation
        weights = np.where(apart, areas, 0)
        summed = np.bincount(cell.ravel(), weights.ravel(), len(itself) * shells * elevations)
        contexts.append(summed.reshape(len(itself), -1))
    return np.concatenate(contexts)
