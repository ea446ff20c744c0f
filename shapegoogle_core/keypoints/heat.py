# SPDX-License-Identifier: MIT
"""Where heat stays longest: maxima of the heat kernel (Sun et al. 2009; Gebal et al. 2009)."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.descriptors import heat_kernel_signature
from shapegoogle_core.keypoints.persistence import persistent_maxima
from shapegoogle_core.mesh.connectivity import unique_edges
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.spectral import Spectrum

__all__ = ["hks_maxima"]


def hks_maxima(mesh: Mesh, spectrum: Spectrum, time: float = 0.0256, persistence: float = 0.1) -> FloatArray:
    """Find where heat stays longest: tips of limbs, at large times (Sun, Ovsjanikov, Guibas 2009).

    Maxima of K_t(x, x), without those that hardly rise above the saddle to a higher one (Gebal et al. 2009;
    Skraba et al. 2010).

    Parameters
    ----------
    mesh : Mesh
        Its edges say which vertices are neighbours.
    spectrum : Spectrum
    time : float
        t as a share of the area: that of the paper's figure 4 by default. The larger, the larger is what
        counts as a feature.
    persistence : float
        Least rise of a maximum above where it merges with a higher one, as a share of its own height.

    Returns
    -------
    response : (n,) array
        That rise at the points found, between 0 and 1; 0 at the other vertices.

    Notes
    -----
    The rise is measured against the maximum's own height, as if persistence were that of log K: the thinnest
    tip of a shape holds many times the heat of a thick one, which would vanish beside it; so would a whole
    shape beside a small loose part of it.
    """
    (heat,) = heat_kernel_signature(spectrum, time * spectrum.area).T
    maxima, deaths = persistent_maxima(heat, unique_edges(mesh)[0])
    heights = heat[maxima]
    # Parts that the truncated spectrum leaves out have no heat, and no maximum.
    rise = np.divide(heights - deaths, heights, out=np.zeros_like(heights), where=heights > 0)
    response = np.zeros(len(heat))
    response[maxima] = np.where(rise >= persistence, rise, 0.0)
    return response
