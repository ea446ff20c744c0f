# SPDX-License-Identifier: MIT
"""Keypoint detection (paper, section 3.1 and algorithm 2, lines 1 to 4)."""

from __future__ import annotations

import inspect
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import MeshError
from shapegoogle_core.keypoints.registry import DETECTORS
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.spectral import Spectrum

__all__ = ["Keypoints", "detect_keypoints"]


@dataclass(frozen=True, eq=False)
class Keypoints:
    """Points of a shape that stand out.

    Attributes
    ----------
    indices : (p,) array of int
        Vertices of the mesh, the strongest first; of equals the one with the smaller index.
    response : (p,) array
        How much each stands out, > 0; what that means is the detector's.
    """

    indices: NDArray[np.int64]
    response: FloatArray

    def __len__(self) -> int:
        return len(self.indices)


def detect_keypoints(
    mesh: Mesh, spectrum: Spectrum, detector: str = "hks-maxima", **parameters: float
) -> Keypoints:
    """Find the points of a shape that stand out (paper, section 3.1).

    Parameters
    ----------
    mesh : Mesh
        Repaired: every vertex belongs to a face. Made for some thousand vertices, to which a model's mending
        brings every shape.
    spectrum : Spectrum
        Of that mesh.
    detector : {"hks-maxima", "mesh-dog", "salient-points", "harris-3d"}
        A key of `DETECTORS`; the function it names says what is found.
    **parameters : float
        Of that function.

    Returns
    -------
    keypoints : Keypoints
        Not changed by rigid motions and scaling; those of "hks-maxima" neither by bending. None on a shape
        that is everywhere alike.

    Raises
    ------
    ValueError
        If there is no such detector, it has no such parameter, or that is not positive.
    MeshError
        If mesh and spectrum do not fit, or an operator cannot be assembled.
    """
    if detector not in DETECTORS:
        raise ValueError(f"detector must be one of {', '.join(DETECTORS)}, not {detector!r}")
    if len(mesh.vertices) != len(spectrum.mass) or mesh.is_point_cloud:
        raise MeshError(
            f"{mesh.name!r} has {len(mesh.vertices)} vertices and {len(mesh.faces)} faces, its spectrum "
            f"{len(spectrum.mass)} vertices; keypoints need a mesh of triangles and the spectrum of that mesh"
        )
    known = list(inspect.signature(DETECTORS[detector]).parameters)[2:]
    for name, value in parameters.items():
        if name not in known:
            raise ValueError(f"{detector!r} has no parameter {name!r}; it has {', '.join(known)}")
        if not 0 < value < math.inf:
            raise ValueError(f"{name} of {detector!r} must be positive, not {value!r}")
    response = DETECTORS[detector](mesh, spectrum, **parameters)
    indices = np.flatnonzero(response > 0)
    indices = indices[np.argsort(-response[indices], kind="stable")]
    return Keypoints(indices, response[indices])
