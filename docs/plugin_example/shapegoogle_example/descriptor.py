# SPDX-License-Identifier: MIT
"""A descriptor: the distance of each vertex from the centroid."""

import numpy as np
from numpy.typing import NDArray

import shapegoogle_core as sg


def shells(mesh: sg.Mesh, spectrum: sg.Spectrum, count: int = 8) -> NDArray[np.float64]:
    """Say in which of some shells around the centroid each vertex lies, softly.

    Parameters
    ----------
    mesh : Mesh
    spectrum : Spectrum
    count : int, optional
        Number of shells. Parameters of a descriptor need default values for `shapegoogle train`.

    Returns
    -------
    values : (n, count) array
    """
    centroid = spectrum.mass @ mesh.vertices / spectrum.mass.sum()
    # As a share of √area, so that the size does not matter.
    away = np.linalg.norm(mesh.vertices - centroid, axis=1) / np.sqrt(mesh.area)
    radii, width = np.linspace(0.1, 0.8, count), 0.7 / count
    return np.exp(-(((away[:, None] - radii) / width) ** 2))
