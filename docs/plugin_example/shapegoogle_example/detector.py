# SPDX-License-Identifier: MIT
"""A keypoint detector: vertices farther from the centroid than all around them."""

import numpy as np
from numpy.typing import NDArray

import shapegoogle_core as sg


def far_points(mesh: sg.Mesh, spectrum: sg.Spectrum, least: float = 0.2) -> NDArray[np.float64]:
    """Find vertices farther from the centroid than their neighbours.

    Parameters
    ----------
    mesh : Mesh
    spectrum : Spectrum
    least : float, optional
        Least distance, as a share of √area.

    Returns
    -------
    response : (n,) array
        The distance at keypoints, 0 elsewhere.
    """
    centroid = spectrum.mass @ mesh.vertices / spectrum.mass.sum()
    away = np.linalg.norm(mesh.vertices - centroid, axis=1) / np.sqrt(mesh.area)
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    farthest_around = np.zeros(len(away))
    np.maximum.at(farthest_around, edges[:, 0], away[edges[:, 1]])
    np.maximum.at(farthest_around, edges[:, 1], away[edges[:, 0]])
    return np.where((away > farthest_around) & (away >= least), away, 0.0)
