# SPDX-License-Identifier: MIT
"""Features that the network finds in pictures of normals, and their whitening."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from benchmarks.network.graph import FEATURES
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.views import VIEW_ROTATIONS, normal_pictures, surface_points
from shapegoogle_core.views.points import fit_into_ball

__all__ = ["PICTURES", "NetworkFeatures", "whitened"]

Floats = NDArray[np.float32]

# Of two opposite directions one is enough: their outlines are mirror images.
_ROTATIONS = np.array([frame for frame in VIEW_ROTATIONS if tuple(frame[2].round(3)) > (0, 0, 0)])
PICTURES = 2 * len(_ROTATIONS)
"""Pictures of a shape: half of them in the file's axes, half in the principal axes."""

# The product's pictures, enlarged to what the network was found to need.
_POINTS, _PIXELS, _ENLARGED = 30_000, 64, 2


class NetworkFeatures:
    """Describe shapes by the network, in one thread.

    Parameters
    ----------
    model : bytes
        ONNX model, from `lite0_graph`.
    """

    def __init__(self, model: bytes) -> None:
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self._session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])

    def describe(self, mesh: Mesh) -> Floats:
        """Describe a shape.

        Parameters
        ----------
        mesh : Mesh

        Returns
        -------
        features : (12, 1280) array of float32
            Square roots of the pooled features of each picture.
        """
        (features,) = self._session.run(["features"], {"pictures": network_pictures(mesh)})
        return np.asarray(np.sqrt(np.maximum(features, 0)), np.float32)


def network_pictures(mesh: Mesh) -> Floats:
    """Draw a shape for the network: normals as colours on white.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    pictures : (12, 3, 128, 128) array of float32
        From -1 to 1; white is 1.
    """
    points, normals = surface_points(mesh, _POINTS)
    drawn = []
    for axes in (np.eye(3), _principal_axes(points)):
        turned = fit_into_ball(points @ axes.T)
        drawn.append(normal_pictures(turned, normals @ axes.T, _ROTATIONS, _PIXELS)[..., :3])
    pictures = np.concatenate(drawn)
    pictures[~pictures.any(axis=-1)] = 1
    enlarged = pictures.repeat(_ENLARGED, axis=1).repeat(_ENLARGED, axis=2)
    return np.ascontiguousarray(enlarged.transpose(0, 3, 1, 2))


def whitened(examples: Iterable[Floats], components: int) -> tuple[FloatArray, FloatArray]:
    """Learn a whitening of features from any shapes.

    Parameters
    ----------
    examples : iterable of (12, 1280) array
    components : int

    Returns
    -------
    mean : (1280,) array
    projection : (1280, components) array
        Principal components, divided by their standard deviation.
    """
    features = np.concatenate(list(examples)).astype(np.float64)
    mean = features.mean(axis=0)
    centred = features - mean
    values, vectors = np.linalg.eigh(centred.T @ centred / len(centred))
    kept = slice(FEATURES - components, None)
    return mean, vectors[:, kept] / np.sqrt(values[kept])


def _principal_axes(points: FloatArray) -> FloatArray:
    """Rows in the order of the spread of points, each towards the side where they reach farther."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1][:, ::-1].T
    lean = ((centred @ axes.T) ** 3).sum(axis=0)
    return np.asarray(axes * np.where(lean < 0, -1, 1)[:, None])
