# SPDX-License-Identifier: MIT
"""Maxima of the heat kernel, where heat stays longest (paper, section 3.1)."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.descriptors import heat_kernel_signature
from shapegoogle_core.keypoints.persistence import persistent_maxima
from shapegoogle_core.mesh.connectivity import unique_edges
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.spectral import Spectrum

__all__ = ["hks_maxima"]


def hks_maxima(mesh: Mesh, spectrum: Spectrum, time: float = 0.0256, persistence: float = 0.1) -> FloatArray:
    """Find where heat stays longest, the tips of limbs at large times (Sun, Ovsjanikov, Guibas 2009).

    Maxima of K_t(x, x), except those that hardly rise above the saddle to a higher maximum (Gebal et al.
    2009; Skraba et al. 2010).

    Parameters
    ----------
    mesh : Mesh
        Its edges define which vertices are neighbours.
    spectrum : Spectrum
        Spectrum of the mesh.
    time : float
        t as a share of the area; by default that of the paper's figure 4. Larger times find larger features.
    persistence : float
        Least rise of a maximum above the height at which it merges with a higher one, as a share of its own
        height.

    Returns
    -------
    response : (n,) array
        That rise at the keypoints, between 0 and 1; 0 at the other vertices.

    Notes
    -----
    The rise is relative to the maximum's own height, similar to the persistence of log K: the thinnest tip of
    a shape has many times the heat of a thick one, which would otherwise vanish beside it, as would a whole
    shape beside a small loose part.
    """
    (heat,) = heat_kernel_signature(spectrum, time * spectrum.area).T
    maxima, deaths = persistent_maxima(heat, unique_edges(mesh)[0])
    heights = heat[maxima]
    # Components that the truncated spectrum leaves out have no heat, and no maximum.
    rise = np.divide(heights - deaths, heights, out=np.zeros_like(heights), where=heights > 0)
    response = np.zeros(len(heat))
    response[maxima] = np.where(rise >= persistence, rise, 0.0)
    return response
