# SPDX-License-Identifier: MIT
"""Descriptions of a whole shape from before Shape Google, to compare with."""

from __future__ import annotations

import numpy as np
import trimesh

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectrum import Spectrum

__all__ = ["D2_BINS", "D2_RANGE", "D2_SAMPLES", "d2_distribution", "shape_dna"]

D2_SAMPLES = 1 << 17
"""Pairs of points; Osada et al. take 1024², eight times as many, for a third of the sampling noise."""

D2_BINS = 64

D2_RANGE = 3.0
"""End of the histogram in mean distances: that of the ends of a rod, the most an even shape has."""


def shape_dna(spectrum: Spectrum, count: int = 49) -> FloatArray:
    """Shape-DNA: the first eigenvalues of the Laplace–Beltrami operator (Reuter, Wolter, Peinecke 2006).

    Eigenvalues are multiplied by the area, so that size does not matter, and the j-th is divided by 4πj,
    what it is by Weyl's law on any surface for large j. Without the second step the Euclidean distance, by
    which Shape-DNA is compared, would see the last eigenvalues alone: they grow with j, and their
    differences with them.

    Parameters
    ----------
    spectrum : Spectrum
        Of more than `count` pairs.
    count : int
        How many eigenvalues; the first, which is 0 on every surface, is left out.

    Returns
    -------
    dna : (count,) array
        λ_j A / 4πj for j = 1 … count, without a unit; compare by the Euclidean distance. A shape of c parts
        that do not touch starts with c − 1 zeros: that it is in parts is something to know it by. A
        coarse mesh has fewer eigenvalues than `count`; 1, which Weyl's law says, stands for the others.

    Raises
    ------
    ValueError
        If count < 1.
    """
    if count < 1:
        raise ValueError(f"Shape-DNA needs at least one eigenvalue, not {count}")
    dna = np.ones(count)
    known = spectrum.eigenvalues[1 : count + 1]
    dna[: len(known)] = known * spectrum.area / (4 * np.pi * np.arange(1, len(known) + 1))
    return dna


def d2_distribution(mesh: Mesh, samples: int = D2_SAMPLES, bins: int = D2_BINS, seed: int = 0) -> FloatArray:
    """D2 shape distribution: how far apart two random points of a surface are (Osada et al. 2002).

    Parameters
    ----------
    mesh : Mesh
    samples : int
        Pairs of points, each uniform on the surface. The histogram's error falls with their root.
    bins : int
    seed : int
        Of the points.

    Returns
    -------
    histogram : (bins,) array
        Share of the pairs whose distance, divided by the mean of all, falls into equal bins of
        0 … `D2_RANGE`; the last one also holds what is farther. Sums to 1; compare by the L1 distance, as
        Osada et al. do.

    Raises
    ------
    MeshError
        If the mesh has no surface.
    ValueError
        If there are no samples or no bins.
    """
    if samples < 1 or bins < 1:
        raise ValueError(f"D2 needs at least one sample and one bin, not {samples} and {bins}")
    if not mesh.area > 0:
        raise MeshError(f"{mesh.name!r} has no surface to take points from")
    surface = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    points = trimesh.sample.sample_surface(surface, 2 * samples, seed=seed)[0]
    distances = np.linalg.norm(points[:samples] - points[samples:], axis=1)
    relative = np.minimum(distances / distances.mean(), D2_RANGE)
    counts, _ = np.histogram(relative, bins, (0.0, D2_RANGE))
    histogram: FloatArray = counts / samples
    return histogram
