# SPDX-License-Identifier: GPL-3.0-or-later
"""Spectra, words and keypoints of objects, kept while the file is open so that the slider repaints fast."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import state
from ..scene.meshes import base_mesh
from . import attributes, layers
from .choices import Painting
from .layers import Layer
from .picked import picked

if TYPE_CHECKING:
    from shapegoogle_core import Mesh, ShapeModel, VertexKeypoints, VertexSpectrum, VertexWords

    Result = VertexSpectrum | VertexWords | VertexKeypoints

__all__ = ["Key", "Known", "Task", "key_of", "known", "paint_layers", "remember", "task_of"]

Key = tuple[object, ...]
MOST_BYTES = 512 * 2**20


@dataclass(frozen=True, eq=False)
class Known:
    """Result of a computation on an object.

    Attributes
    ----------
    result : VertexSpectrum, VertexWords or VertexKeypoints
    size : float
        Diagonal of its bounding box in world units.
    """

    result: Result
    size: float

    @property
    def bytes(self) -> int:
        """Memory of its arrays."""
        from shapegoogle_core import VertexSpectrum, VertexWords

        matrix, result = self.result.prolongation, self.result
        if isinstance(result, VertexSpectrum):
            functions = result.spectrum.eigenvectors
        else:
            functions = result.words if isinstance(result, VertexWords) else result.strength
        return int(functions.nbytes + matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes)


@dataclass(frozen=True, eq=False)
class Task:
    """Computation on an object; the function belongs to the core, so that a worker process can run it.

    Attributes
    ----------
    key : tuple
    name : str
        Of the object.
    function : callable
    arguments : tuple
    size : float
        As in `Known`.
    seconds : float
        Estimated duration.
    """

    key: Key
    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    size: float
    seconds: float


def key_of(item: Any, chosen: Painting, model: ShapeModel | None) -> Key:
    """Key of the result that a painting needs of an object.

    Parameters
    ----------
    item : bpy.types.Object
    chosen : Painting
    model : ShapeModel or None
        Whose words, for the kind WORDS.
    """
    geometry = attributes.geometry_hash(item)
    if chosen.kind == "WORDS":
        return geometry, None if model is None else model.identifier, chosen.channel
    spectrum = geometry, chosen.eigenpairs, chosen.laplacian, chosen.budget
    return (*spectrum, chosen.detector) if chosen.kind == "KEYPOINTS" else spectrum


def task_of(item: Any, chosen: Painting, model: ShapeModel | None, key: Key) -> Task:
    """Prepare the computation that a painting needs.

    Parameters
    ----------
    item : bpy.types.Object
    chosen : Painting
    model : ShapeModel or None
    key : tuple
        From `key_of`.

    Returns
    -------
    task : Task

    Raises
    ------
    MeshError
        If a coordinate is not finite, or the model has no such words.
    """
    from shapegoogle_core import MeshError, vertex_keypoints, vertex_spectrum, vertex_words

    mesh = base_mesh(item)
    count = len(mesh.vertices)
    size = _diagonal(mesh)
    if chosen.kind != "WORDS" or model is None:
        solved = min(count, chosen.budget or count)
        seconds = 1e-6 * solved * chosen.eigenpairs + 2e-5 * count
        arguments = chosen.eigenpairs, chosen.laplacian, chosen.budget
        if chosen.kind == "KEYPOINTS":
            seconds += 1e-8 * solved**2  # discs of detectors
            return Task(key, item.name, vertex_keypoints, (mesh, chosen.detector, *arguments), size, seconds)
        return Task(key, item.name, vertex_spectrum, (mesh, *arguments), size, seconds)
    descriptors = [channel.descriptor for channel in model.settings.channels]
    if chosen.channel not in descriptors:
        raise MeshError(
            "the model {model!r} has no words of {channel!r}; choose one of {channels}",
            model=model.name,
            channel=chosen.channel,
            channels=", ".join(descriptors),
        )
    channel = descriptors.index(chosen.channel)
    return Task(key, item.name, vertex_words, (model, mesh, channel), size, 1.0 + 2e-5 * count)


def _diagonal(mesh: Mesh) -> float:
    """Diagonal of the box around the faces of a mesh."""
    if not len(mesh.faces):
        return 0.0
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces.ravel()] = True
    # Mostly all are: to pick those of half a million vertices takes as long as a redraw.
    vertices = mesh.vertices if used.all() else mesh.vertices[used]
    return float(np.linalg.norm(vertices.max(axis=0) - vertices.min(axis=0)))


def known(key: Key) -> Known | None:
    """Return an earlier result; None if there is none."""
    results = state.current().signature.results
    entry = results.get(key)
    if entry is not None:
        results.move_to_end(key)
    return entry


def remember(task: Task, result: Result) -> Known:
    """Keep a result; the oldest ones go when all together take more than `MOST_BYTES`."""
    results = state.current().signature.results
    entry = results[task.key] = Known(result, task.size)
    while len(results) > 1 and sum(each.bytes for each in results.values()) > MOST_BYTES:
        results.popitem(last=False)
    return entry


def paint_layers(item: Any, chosen: Painting, entry: Known, source: int | None = None) -> list[Layer]:
    """Attributes of an object, from the result of its computation.

    Parameters
    ----------
    item : bpy.types.Object
    chosen : Painting
    entry : Known
    source : int, optional
        Vertex that heat spreads from; left out, the one that is selected.

    Returns
    -------
    layers : list of Layer

    Raises
    ------
    MeshError
        If the object has no such values.
    """
    from shapegoogle_core import MeshError, VertexKeypoints, VertexWords

    if isinstance(entry.result, VertexKeypoints):
        return layers.paint_keypoints(entry.result)
    if isinstance(entry.result, VertexWords):
        return layers.paint_words(chosen, entry.result)
    if chosen.kind == "HEAT" and source is None:
        vertex = picked(item)
        source = None if vertex is None else vertex.index
    try:
        return layers.paint_spectrum(chosen, entry.result, source)
    except MeshError as error:
        raise MeshError("{name!r}: {reason}", name=item.name, reason=error) from error
