# SPDX-License-Identifier: MIT
"""Mending: what happens to every mesh, query or library, before it is described."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shapegoogle_core.mesh.checks import check_cloud, check_surface
from shapegoogle_core.mesh.cloud import thin
from shapegoogle_core.mesh.mesh import Mesh
from shapegoogle_core.preprocessing.holes import close_holes
from shapegoogle_core.preprocessing.repair import repair
from shapegoogle_core.preprocessing.resampling import resample
from shapegoogle_core.preprocessing.smoothing import smooth

__all__ = ["Mending", "mend", "mend_cloud"]


@dataclass(frozen=True)
class Mending:
    """How meshes, and points without faces, are mended.

    Parameters
    ----------
    close_holes : float
        Largest hole that is closed, as a share of the bounding-box diagonal; 0 closes none. Points have none.
    floor, budget : int
        Fewest and most vertices. There is no floor for points.
    smoothing : float
        Time of the smoothing step as a share of the area (see `smooth`); 0 leaves the surface as it is.
    """

    close_holes: float = 0.45
    floor: int = 1000
    budget: int = 5000
    smoothing: float = 3e-4

    def __post_init__(self) -> None:
        if not (0 <= self.close_holes <= 1 and 0 <= self.smoothing < math.inf and self.budget >= 4):
            raise ValueError(f"mending out of range: {self}")


def mend(mesh: Mesh, mending: Mending) -> Mesh:
    """Repair a mesh, close its holes, bring it to a working resolution and smooth it.

    Parameters
    ----------
    mesh : Mesh
        As read.
    mending : Mending

    Returns
    -------
    mended : Mesh

    Raises
    ------
    MeshError
        If the mesh is no surface, before or after repair (see `check_surface`).
    """
    check_surface(mesh)
    mesh = repair(mesh)
    check_surface(mesh)
    mesh = close_holes(mesh, mending.close_holes)
    mesh = resample(mesh, mending.floor, mending.budget)
    return smooth(mesh, mending.smoothing)


def mend_cloud(mesh: Mesh, mending: Mending) -> Mesh:
    """Weld points without faces, thin them to a working resolution and smooth them as a mesh is smoothed.

    Parameters
    ----------
    mesh : Mesh
        Without faces, as read.
    mending : Mending

    Returns
    -------
    mended : Mesh
        Without faces.

    Raises
    ------
    MeshError
        If the points are no shape (see `check_cloud`), or they have no Laplacian to be smoothed with.
    """
    check_cloud(mesh)
    thinned = Mesh(thin(repair(mesh).vertices, mending.budget), name=mesh.name)
    check_cloud(thinned)
    return smooth(thinned, mending.smoothing)
