# SPDX-License-Identifier: MIT
"""Keypoint detection (paper, section 3.1 and algorithm 2, lines 1 to 4)."""

from __future__ import annotations

import inspect
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.api.arguments import check_number
from shapegoogle_core.errors import MeshError
from shapegoogle_core.keypoints.registry import DETECTORS
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import Spectrum, check_spectrum

__all__ = ["Keypoints", "detect_keypoints"]


@dataclass(frozen=True, eq=False)
class Keypoints:
    """Keypoints of a shape (paper, section 3.1).

    Attributes
    ----------
    indices : (p,) array of int
        Vertices of the mesh, the strongest first; of equally strong ones the smaller index first.
    response : (p,) array
        Strength of each keypoint, > 0. Its meaning depends on the detector.

    See Also
    --------
    detect_keypoints : Find the keypoints of a mesh.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> points = sg.Keypoints(np.array([7, 2]), np.array([0.9, 0.4]))
    >>> len(points), points.indices.tolist()
    (2, [7, 2])
    """

    indices: NDArray[np.int64]
    response: FloatArray

    def __len__(self) -> int:
        return len(self.indices)


def detect_keypoints(
    mesh: MeshLike, spectrum: Spectrum, detector: str = "hks-maxima", **parameters: float
) -> Keypoints:
    """Find the keypoints of a shape (paper, section 3.1 and algorithm 2, lines 1 to 4).

    Parameters
    ----------
    mesh : MeshLike
        A repaired mesh, in which every vertex belongs to a face. The detectors are intended for some thousand
        vertices, the resolution to which the preprocessing of a model brings every shape.
    spectrum : Spectrum
        Spectrum of that mesh.
    detector : {"hks-maxima", "mesh-dog", "salient-points", "harris-3d"}, or that of a plug-in
        "hks-maxima": maxima of the heat kernel signature, at tips (Sun et al. 2009). "mesh-dog": extrema of
        the mean curvature in scale space (Zaharescu et al. 2009). "salient-points": where smoothing moves
        the surface most (Castellani et al. 2008). "harris-3d": corners (Sipiran and Bustos 2010).
    **parameters : float
        Parameters of the detector's function in `shapegoogle_core.keypoints`, for example ``time`` and
        ``persistence`` of `hks_maxima`. Lengths are shares of √area, times are shares of the area.

    Returns
    -------
    keypoints : Keypoints
        Rigid motions and scaling do not change them; bending does not change those of "hks-maxima". A shape
        that is the same everywhere has none.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum`, the detector is unknown, it has no parameter of that name,
        or a parameter is not positive.
    MeshError
        If the mesh has no faces, the spectrum is of another mesh, or an operator cannot be assembled.
    PluginError
        If the detector is that of a plug-in, and cannot be loaded or fails.

    Examples
    --------
    >>> import numpy as np
    >>> import trimesh
    >>> import shapegoogle_core as sg
    >>> ball = trimesh.creation.icosphere(subdivisions=3)
    >>> tip = 1 + np.exp(20 * (ball.vertices[:, 2:] - 1))
    >>> mesh = sg.Mesh(ball.vertices * tip, ball.faces, name="ball with a tip")
    >>> keypoints = sg.detect_keypoints(mesh, sg.compute_spectrum(mesh))
    >>> mesh.vertices[keypoints.indices[0]].round(3).tolist()
    [0.0, 0.0, 2.0]
    """
    mesh = as_mesh(mesh)
    if detector not in DETECTORS:
        raise ValueError(f"detector must be one of {', '.join(DETECTORS)}, not {detector!r}")
    check_spectrum(spectrum)
    if len(mesh.vertices) != len(spectrum.mass) or mesh.is_point_cloud:
        raise MeshError(
            f"{mesh.name!r} has {len(mesh.vertices)} vertices and {len(mesh.faces)} faces, its spectrum "
            f"{len(spectrum.mass)} vertices; keypoints need a mesh of triangles and the spectrum of that mesh"
        )
    known = list(inspect.signature(DETECTORS[detector]).parameters)[2:]
    for name, value in parameters.items():
        if name not in known:
            raise ValueError(f"{detector!r} has no parameter {name!r}; it has {', '.join(known)}")
        check_number(f"{name} of {detector!r}", value, positive=True)
    response = DETECTORS[detector](mesh, spectrum, **parameters)
    indices = np.flatnonzero(response > 0)
    indices = indices[np.argsort(-response[indices], kind="stable")]
    return Keypoints(indices, response[indices])
