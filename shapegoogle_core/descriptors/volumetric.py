# SPDX-License-Identifier: MIT
"""Volumetric heat kernel signature, of the heat inside a solid (paper, section 1.1)."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array, csc_array, diags_array, eye_array

from shapegoogle_core.descriptors.spectral import LEAST_HEAT, heat_kernel_signature
from shapegoogle_core.laplacian import Operator
from shapegoogle_core.mesh import MeshLike, clean_surface
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import operator_spectrum

__all__ = ["volumetric_hks"]

# Largest number of cubes along the diagonal of the bounding box: distant parts must not fill the memory.
_MOST_CUBES = 250


def volumetric_hks(
    mesh: MeshLike, times: ArrayLike, resolution: int = 30, eigenpairs: int = 100
) -> FloatArray:
    """Volumetric heat kernel signature of every vertex (paper, section 1.1; Raviv et al. 2010).

    log(V · K_t(x, x)), with the volume V and the heat kernel K_t(x, x) = Σ_l exp(-λ_l t) φ_l(x)². The solid
    consists of the cubes of a grid that the surface passes through or encloses; -Δ is the seven-point stencil
    on them, and no heat flows through the boundary (Neumann). Bending that preserves the volume does not
    change the values, as on the surface; unlike there, a flat body differs from a round one with the same
    surface. The grid does not turn with the shape: a rotation changes the values a little, less with a higher
    resolution.

    Parameters
    ----------
    mesh : MeshLike
        A mesh of triangles. It need not be closed: a sheet is a layer of cubes.
    times : (d,) array_like
        Times t > 0, as shares of the surface's area.
    resolution : int
        Number of cubes along the square root of the surface's area. Time and memory grow with its square to
        cube.
    eigenpairs : int
        Number of eigenpairs.

    Returns
    -------
    values : (n, d) array
        Interpolated linearly between the centres of cubes. Dimensionless; falls to 0 for large t. At least
        -10, which stands for no heat, see `log_heat_kernel_signature`.

    Raises
    ------
    ValueError
        If a parameter is out of range.
    MeshError
        If the shape is not a surface, or a vertex has no area.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> mesh = sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    >>> values = sg.volumetric_hks(mesh, [0.01, 0.1, 10.0], resolution=10, eigenpairs=20)
    >>> values.shape, abs(round(float(values[0, 2]), 6))
    ((4, 3), 0.0)
    """
    mesh = clean_surface(mesh)
    if resolution < 1 or eigenpairs < 1:
        raise ValueError(f"resolution and eigenpairs must be at least 1, not {resolution} and {eigenpairs}")
    import trimesh  # slow to import, and only needed here

    unit = math.sqrt(mesh.area)
    # The grid starts at a corner of the bounding box, and the square root of the area is 1.
    points = (mesh.vertices - mesh.vertices.min(axis=0)) / unit
    cube = max(1 / resolution, float(np.linalg.norm(points.max(axis=0))) / _MOST_CUBES)
    grid = trimesh.Trimesh(points, mesh.faces, process=False).voxelized(cube).fill()
    number = np.full(np.add(grid.matrix.shape, 2), -1)  # an empty layer around it
    solid = np.pad(grid.matrix, 1)
    number[solid] = np.arange(solid.sum())
    spectrum = operator_spectrum(_grid_operator(number, cube), eigenpairs)
    heat = spectrum.area * heat_kernel_signature(spectrum, times)  # the "area" of a solid is its volume
    at_cubes = np.log(np.maximum(heat, LEAST_HEAT))
    return _interpolated(at_cubes, number, (points - grid.translation) / cube + 1)


def _grid_operator(number: NDArray[np.int64], cube: float) -> Operator:
    """Assemble -Δ on numbered cubes: heat flows through a common face of area h² over the distance h."""
    pairs = []
    for axis in range(3):
        along = np.moveaxis(number, axis, 0)
        both = (along[1:] >= 0) & (along[:-1] >= 0)
        pairs.append(np.stack([along[1:][both], along[:-1][both]]))
    start, end = np.concatenate(pairs, axis=1)
    count = int(number.max()) + 1
    ends = np.concatenate([start, end]), np.concatenate([end, start])
    neighbors = csc_array(coo_array((np.full(2 * len(start), cube), ends), shape=(count, count)))
    stiffness = csc_array(diags_array(neighbors.sum(axis=0)) - neighbors)
    return Operator(stiffness, csc_array(cube**3 * eye_array(count)))


def _interpolated(at_cubes: FloatArray, number: NDArray[np.int64], places: FloatArray) -> FloatArray:
    """Interpolate between the centres of those of the eight cubes around each place that are in the solid."""
    corner = np.floor(places).astype(np.int64)
    share = places - corner
    values, total = np.zeros((len(places), at_cubes.shape[1])), np.zeros((len(places), 1))
    for step in product((0, 1), repeat=3):
        cubes = number[tuple((corner + step).T)]
        weight = np.where(step, share, 1 - share).prod(axis=1) * (cubes >= 0)
        values += weight[:, None] * at_cubes[cubes]
        total += weight[:, None]
    return np.asarray(values / total)
