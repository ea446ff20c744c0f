# SPDX-License-Identifier: MIT
"""From a mesh to its bags: the steps of figure 2 that need vocabularies, and nothing else that is learnt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import MeshError
from shapegoogle_core.keypoints import detect_keypoints
from shapegoogle_core.laplacian import POINT_CLOUD, build_operator
from shapegoogle_core.mesh import Mesh, check_cloud, check_surface
from shapegoogle_core.mesh.connectivity import used_vertices
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.settings import DESCRIPTORS, ModelSettings
from shapegoogle_core.preprocessing import preprocess, repair
from shapegoogle_core.spectral import Spectrum, compute_spectrum
from shapegoogle_core.words import bag_of_features, hard_words, soft_words, spatially_sensitive_bag

__all__ = [
    "ChannelWords",
    "FloatBags",
    "Placement",
    "WorkingShape",
    "channel_words",
    "counted_points",
    "prepare",
    "prepare_placed",
    "shape_bags",
    "working_shape",
]

FloatBags = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ChannelWords:
    """The learnt vocabulary of one channel.

    Attributes
    ----------
    centers : (V, d) array
        The words, in the unit of the descriptor.
    sigma : float
        Width of the soft words, in the same unit.
    """

    centers: FloatArray
    sigma: float


@dataclass(frozen=True, eq=False)
class Placement:
    """Where a prepared mesh came from: x_prepared = scale · (x - origin).

    Attributes
    ----------
    origin : (3,) array
        In the unit of the mesh as given.
    scale : float
    """

    origin: FloatArray
    scale: float

    def of(self, points: FloatArray) -> FloatArray:
        """Move (n, 3) points as the mesh was moved."""
        return np.asarray((points - self.origin) * self.scale)

    def back(self, mesh: Mesh) -> Mesh:
        """Move a prepared mesh to where the mesh as given was."""
        return Mesh(mesh.vertices / self.scale + self.origin, mesh.faces, mesh.name)


def prepare(settings: ModelSettings, mesh: Mesh) -> Mesh:
    """Mend a mesh and scale it to the working area.

    Parameters
    ----------
    settings : ModelSettings
    mesh : Mesh

    Returns
    -------
    prepared : Mesh
        Of area `settings.area`, centred on its bounding box. Without faces if it had none.

    Raises
    ------
    MeshError
        If the mesh has no surface, or its points are none of a surface.
    """
    return prepare_placed(settings, mesh)[0]


def prepare_placed(settings: ModelSettings, mesh: Mesh) -> tuple[Mesh, Placement]:
    """Prepare a mesh as `prepare` does, and say how it was moved.

    Parameters
    ----------
    settings : ModelSettings
    mesh : Mesh

    Returns
    -------
    prepared : Mesh
    placement : Placement

    Raises
    ------
    MeshError
        If the mesh has no surface, or its points are none of a surface.
    """
    if mesh.is_point_cloud:
        return _prepare_cloud(settings, mesh)
    check_surface(mesh)
    used, faces = used_vertices(mesh.faces, len(mesh.vertices))  # a stray vertex must not set the scale
    vertices = mesh.vertices[used]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    # To unit size first: squares of very small or very large coordinates would leave the range of floats.
    origin, size = (low + high) / 2, float(np.linalg.norm(high - low))
    centered = Mesh((vertices - origin) / size, faces, mesh.name)
    repaired = _preprocessed(settings, centered)
    area = repaired.area
    if not area > 0:
        raise MeshError(f"{mesh.name!r} has no surface left after repair: all faces are degenerate")
    scale = float(np.sqrt(settings.area / area))
    return Mesh(repaired.vertices * scale, repaired.faces, mesh.name), Placement(origin, scale / size)


def _prepare_cloud(settings: ModelSettings, mesh: Mesh) -> tuple[Mesh, Placement]:
    """Preprocess points without faces and scale the surface that they stand on to the working area."""
    check_cloud(mesh)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    origin, size = (low + high) / 2, float(np.linalg.norm(high - low))
    centered = Mesh((mesh.vertices - origin) / size, name=mesh.name)
    repaired = _preprocessed(settings, centered)
    area = build_operator(repaired, POINT_CLOUD).lumped_mass.sum()
    scale = float(np.sqrt(settings.area / area))
    return Mesh(repaired.vertices * scale, name=mesh.name), Placement(origin, scale / size)


def _preprocessed(settings: ModelSettings, mesh: Mesh) -> Mesh:
    return repair(mesh) if settings.preprocessing is None else preprocess(mesh, settings.preprocessing)


@dataclass(frozen=True, eq=False)
class WorkingShape:
    """A shape at the working resolution and area.

    Attributes
    ----------
    mesh : Mesh
        See `prepare`. Without faces: points of a surface, whose areas are the spectrum's `mass`.
    spectrum : Spectrum
        Of that mesh.
    placement : Placement
        Where it came from.
    """

    mesh: Mesh
    spectrum: Spectrum
    placement: Placement


def working_shape(settings: ModelSettings, mesh: Mesh) -> WorkingShape:
    """Bring a mesh to the working resolution and area, and decompose it.

    Parameters
    ----------
    settings : ModelSettings
    mesh : Mesh
        Of points without faces the spectrum is that of the "point-cloud" operator, whatever the settings say.

    Returns
    -------
    shape : WorkingShape
        With at most `settings.eigenpairs` eigenpairs.

    Raises
    ------
    MeshError
        If the mesh has no surface, or its eigenproblem cannot be solved.
    """
    prepared, placement = prepare_placed(settings, mesh)
    laplacian = POINT_CLOUD if prepared.is_point_cloud else settings.laplacian
    spectrum = compute_spectrum(prepared, settings.eigenpairs, laplacian, settings.boundary)
    return WorkingShape(prepared, spectrum, placement)


def channel_words(
    settings: ModelSettings, channel: int, vocabulary: ChannelWords, shape: WorkingShape
) -> FloatArray:
    """Express one channel's descriptors of a shape in words.

    Parameters
    ----------
    settings : ModelSettings
    channel : int
        Index of the channel.
    vocabulary : ChannelWords
        Of that channel.
    shape : WorkingShape

    Returns
    -------
    words : (n, V) array
        θ(x) at every vertex.

    Raises
    ------
    MeshError
        If the shape has no such descriptor.
    """
    chosen = settings.channels[channel]
    try:
        descriptors = DESCRIPTORS[chosen.descriptor](shape.mesh, shape.spectrum, **chosen.parameters)
    except MeshError:
        raise
    except ValueError as error:
        # The parameters were tried with the settings: it is the shape that has, say, no positive eigenvalue.
        raise MeshError(f"the descriptor {chosen.descriptor!r} cannot be computed ({error})") from error
    if chosen.soft:
        return soft_words(descriptors, vocabulary.centers, vocabulary.sigma)
    return hard_words(descriptors, vocabulary.centers)


def shape_bags(
    settings: ModelSettings, vocabularies: tuple[ChannelWords, ...], shape: WorkingShape
) -> FloatBags:
    """All bags of a shape side by side, before tf-idf.

    Parameters
    ----------
    settings : ModelSettings
    vocabularies : tuple of ChannelWords
    shape : WorkingShape

    Returns
    -------
    bags : (B,) array of float32
        Of pairs of words the upper triangle, an entry off the diagonal counting for both its halves: every
        bag sums to 1, or its squares do with `settings.square_root` (nearly: where a truncated kernel is
        negative, its root is taken as 0).
    """
    blocks = []
    for index, (channel, vocabulary) in enumerate(zip(settings.channels, vocabularies, strict=True)):
        words, spectrum = channel_words(settings, index, vocabulary, shape), shape.spectrum
        if channel.detector is not None:
            points = counted_points(shape.mesh, spectrum, channel.detector)
            words, spectrum = words[points], spectrum.at(points)
        upper = np.triu_indices(channel.words)
        for kind in channel.bags:
            if "pairs" in kind:
                pairs = spatially_sensitive_bag(
                    words, spectrum, channel.pair_time, area_weighted=kind == "pairs"
                )
                bag = ((2 - np.eye(channel.words)) * pairs)[upper]
            else:
                bag = bag_of_features(words, spectrum.mass if kind == "area" else None)
            blocks.append(np.sqrt(np.maximum(bag, 0)) if settings.square_root else bag)
    return np.concatenate(blocks).astype(np.float32)


def counted_points(mesh: Mesh, spectrum: Spectrum, detector: str) -> NDArray[np.int64]:
    """Choose the points whose words are counted (paper, algorithm 2, lines 1 to 4).

    Parameters
    ----------
    mesh : Mesh
        See `prepare`.
    spectrum : Spectrum
        Of that mesh.
    detector : str
        A key of `shapegoogle_core.keypoints.DETECTORS`.

    Returns
    -------
    vertices : (p,) array of int
        The points it finds, X′ of the algorithm, but those on parts that the truncated spectrum leaves out,
        between which there is no heat. All vertices of a shape where nothing stands out, such as a sphere.
    """
    points = detect_keypoints(mesh, spectrum, detector).indices
    points = points[spectrum.eigenvectors[points].any(axis=1)]
    return points if len(points) else np.arange(len(mesh.vertices))
