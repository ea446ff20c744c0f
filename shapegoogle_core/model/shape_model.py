# SPDX-License-Identifier: MIT
"""`ShapeModel`: from a mesh to its signature, and from signatures to similarities (paper, figure 2)."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.metric import row_distances
from shapegoogle_core.model.model_file import (
    arrays_of,
    check_learnt,
    damage_refused,
    identifier_of,
    pack,
    unpack,
)
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.model.shape_bags import ChannelWords, FloatBags, shape_bags
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.registration import LocalWords, measure_mesh, sample_surface
from shapegoogle_core.views import ViewModel

__all__ = ["ShapeModel"]


@dataclass(frozen=True, eq=False, repr=False)
class ShapeModel:
    """Trained model: everything learnt from training shapes, and the settings of the training.

    Made by `load_model` or `train_model`.

    Attributes
    ----------
    settings : ModelSettings
        Settings of the training.
    vocabularies : tuple of ChannelWords
        Vocabulary of each channel.
    weights : (B,) array of float32
        Weights of tf-idf for each entry of the bags (paper, equation 17); ones where it is not used.
    mean : (B,) array of float32
        Mean of the training bags.
    projection : (B, p) array of float16
        The learnt metric: bags f are compared and hashed as (f - mean) @ projection.
    directions : (s, p) array of float32
        A of the code y = sign(A f + b) (paper, equation 19), with f projected and of unit length.
    thresholds : (s,) array of float32
        b of the code.
    similarity_half, similarity_slope : float
        Calibration of `similarity`: the distance at which it is ½, and its steepness there.
    trained_on : str
        A sentence about the training shapes.
    agreement_gain : float
        Weight of a spatial agreement, see `verified_distance`.
    verified_half, verified_slope : float
        Calibration of the similarity of verified distances.
    local_words : LocalWords or None
        The index of parts, if `settings.local` asks for one.
    views : ViewModel or None
        What describes pictures of shapes. It has its own identifier, since it has nothing to do with bags.

    Raises
    ------
    ModelError
        If an array has another shape than the settings ask for or is not finite, or a number is out of range.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> model = sg.load_model()
    >>> model.name, model.bag_size, model.code_bits
    ('default', 2700, 256)
    >>> box = model.describe(trimesh.creation.box((1, 2, 3)))
    >>> larger = model.describe(trimesh.creation.box((2, 4, 6)))
    >>> torus = model.describe(trimesh.creation.torus(1.0, 0.4))
    >>> distances = model.distances(box.bags, [larger.bags, torus.bags])
    >>> bool(distances[0] < 0.01 < distances[1])
    True
    """

    settings: ModelSettings
    vocabularies: tuple[ChannelWords, ...]
    weights: FloatBags
    mean: FloatBags
    projection: NDArray[np.float16]
    directions: FloatBags
    thresholds: FloatBags
    similarity_half: float
    similarity_slope: float
    trained_on: str
    agreement_gain: float = 0.0
    verified_half: float = 1.0
    verified_slope: float = 1.0
    local_words: LocalWords | None = None
    views: ViewModel | None = None

    def __post_init__(self) -> None:
        check_learnt(self)

    def __repr__(self) -> str:
        return f"ShapeModel({self.name!r}, {self.identifier})"

    @property
    def bag_size(self) -> int:
        """Length B of all bags side by side."""
        return self.settings.bag_size

    @property
    def code_bits(self) -> int:
        """Length s of the binary code."""
        return self.settings.code_bits

    @property
    def name(self) -> str:
        """Name of the preset, for people; `identifier` distinguishes models."""
        return self.settings.name

    @cached_property
    def identifier(self) -> str:
        """16 hexadecimal digits, equal only for models whose bags can be compared; `views` has its own."""
        return identifier_of(self.settings.to_dict(), arrays_of(self._fields()), self.agreement_gain)

    def describe(self, mesh: MeshLike, *, keep_surface: bool = False) -> ShapeSignature:
        """Compute the signature of a shape.

        Parameters
        ----------
        mesh : MeshLike
            A surface of any resolution, size and state of repair, or a point cloud of at least ten points.
        keep_surface : bool, optional
            Keep the preprocessed mesh in the signature: evidence of matches is measured on it. A point cloud
            has none, and its evidence is coarser.

        Returns
        -------
        signature : ShapeSignature

        Raises
        ------
        MeshError
            If the shape cannot be described (see `check_surface` and `check_cloud`), or its eigenproblem
            cannot be solved.

        Examples
        --------
        >>> import shapegoogle_core as sg
        >>> import trimesh
        >>> model = sg.load_model()
        >>> signature = model.describe(trimesh.creation.box((1, 2, 3)), keep_surface=True)
        >>> signature.bags.shape, signature.code.shape, signature.area
        ((2700,), (32,), 22.0)
        >>> signature.surface
        Mesh('mesh', 1006 vertices, 2008 faces)
        """
        mesh = as_mesh(mesh)
        # On matrices of this size a second BLAS thread only doubles the processor time.
        with threadpool_limits(1, user_api="blas"):
            shape = working_shape(self.settings, mesh)
            bags = shape_bags(self.settings, self.vocabularies, shape) * self.weights
            code = self.codes(bags[None])[0]
            sample = local_code = None
            if self.settings.sample is not None:
                sample = sample_surface(shape.mesh, shape.spectrum, self.settings.sample)
                sample = sample.moved_back(shape.placement.origin, shape.placement.scale)
            if sample is not None and self.local_words is not None:
                local_code = self.local_words.code(sample)
            views = None if self.views is None else self.views.describe(mesh)
        cloud = mesh.is_point_cloud
        return ShapeSignature(
            bags=bags,
            code=code,
            area=shape.spectrum.area / shape.placement.scale**2 if cloud else mesh.area,
            vertex_count=len(mesh.vertices),
            face_count=len(mesh.faces),
            sample=sample,
            local_code=local_code,
            extents=mesh.extents,
            measures=measure_mesh(mesh),
            surface=shape.placement.restore(shape.mesh) if keep_surface and not cloud else None,
            views=views,
            view_code=None if self.views is None or views is None else self.views.code(views),
        )

    def embed(self, bags: FloatBags) -> FloatBags:
        """Project bags into the space of the learnt metric.

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes, see `ShapeSignature.bags`.

        Returns
        -------
        vectors : (n, p) array of float32
            Of unit length.
        """
        vectors = (np.asarray(bags, np.float32) - self.mean) @ self._projection
        vectors /= np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(np.float32).tiny)
        return np.asarray(vectors, dtype=np.float32)

    def codes(self, bags: FloatBags) -> NDArray[np.uint8]:
        """Compute the binary codes y = sign(A f + b) of bags (paper, equation 19).

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes.

        Returns
        -------
        codes : (n, s/8) array of uint8
            Packed as by `numpy.packbits`.
        """
        return np.packbits(self.code_projections(bags) > 0, axis=1)

    def code_projections(self, bags: FloatBags, embedded: FloatBags | None = None) -> FloatBags:
        """Compute the projections A f + b, whose signs are the codes.

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes.
        embedded : (n, p) array, optional
            f, the result of `embed`, where it is known already.

        Returns
        -------
        projections : (n, s) array of float32
        """
        embedded = self.embed(bags) if embedded is None else embedded
        return np.asarray(embedded @ self.directions.T + self.thresholds, np.float32)

    def comparable(self, bags: FloatBags, embedded: FloatBags | None = None) -> FloatBags:
        """Compute vectors between which `row_distances` is this model's distance.

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes.
        embedded : (n, p) array, optional
            The result of `embed`, where it is known already.

        Returns
        -------
        vectors : (n, p) or (n, B) array of float32
            For the metric "cosine" the projected bags; for "l1" the bags, divided by their number.
        """
        if self.settings.metric == "cosine":
            return self.embed(bags) if embedded is None else embedded
        count = sum(len(channel.bags) for channel in self.settings.channels)
        return np.asarray(bags, np.float32) / np.float32(count)

    def distances(self, query: ArrayLike, bags: ArrayLike) -> FloatArray:
        """Compute the distances of one shape's bags from others, by `settings.metric`.

        Parameters
        ----------
        query : (B,) array_like
            Bags of one shape, see `ShapeSignature.bags`.
        bags : (n, B) array_like
            Bags of n shapes.

        Returns
        -------
        distances : (n,) array
            At least 0. For the metric "cosine" 1 - cos of the projections; for "l1" Σ|f - f′|, averaged over
            the bags.

        Raises
        ------
        ModelError
            If the bags are of another length than those of this model.
        """
        query, bags = np.asarray(query, np.float32), np.asarray(bags, np.float32)
        if query.shape != (self.bag_size,) or bags.shape[1:] != (self.bag_size,):
            raise ModelError(
                f"bags of this model have {self.bag_size} values, but those of the query are {query.shape} "
                f"and the others {bags.shape}; describe all shapes with this model"
            )
        return row_distances(self.settings.metric, self.comparable(query[None]), self.comparable(bags))

    def verified_distance(self, distance: float, excess: float) -> float:
        """Lower the distance between bags if the two surfaces agree in space.

        d′ = d exp(-k e). The logistic regression behind `similarity` is linear in log d; with the excess e as
        its second variable, k is the ratio of the two coefficients (see `calibrate`).

        Parameters
        ----------
        distance : float
            Distance d from `distances`.
        excess : float
            Agreement e beyond that of unrelated shapes, see `Alignment.excess`.

        Returns
        -------
        distance : float
            d′ ≤ d. Without an agreement it does not change, because bags alone find other poses.
        """
        return distance * math.exp(-self.agreement_gain * excess)

    def similarity(self, distances: FloatArray, *, verified: bool = False) -> FloatArray:
        """Convert distances to similarities from 0 to 1.

        s(d) = 1 / (1 + (d / d_½)^p), fitted on training shapes by logistic regression: the probability that
        a shape at distance d is the same one transformed and not the nearest of fifty different ones, if both
        are equally likely beforehand.

        Parameters
        ----------
        distances : (n,) array
            From `distances`, or from `verified_distance`.
        verified : bool, optional
            Whether the distances are verified. An unchanged distance then means a lower similarity than that
            of bags alone, since verification found no agreement.

        Returns
        -------
        similarity : (n,) array
            1 at distance 0, falling towards 0.
        """
        half, slope = self.similarity_half, self.similarity_slope
        if verified:
            half, slope = self.verified_half, self.verified_slope
        ratio = np.asarray(distances, np.float64) / half
        return np.asarray(1 / (1 + ratio**slope), dtype=np.float64)

    def with_parts(self, *, views: ViewModel | None) -> ShapeModel:
        """Exchange parts of the model that say nothing about bags; its identifier stays.

        Parameters
        ----------
        views : ViewModel or None

        Returns
        -------
        model : ShapeModel
        """
        changed = replace(self, views=views)
        # In the place of the cached property: the file of an early model states another than it has by now.
        vars(changed)["identifier"] = self.identifier
        return changed

    @cached_property
    def _projection(self) -> FloatBags:
        return self.projection.astype(np.float32)

    def _fields(self) -> dict[str, object]:
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}

    def to_bytes(self) -> bytes:
        """Serialise to a numpy .npz archive whose entry `header` is JSON; nothing is pickled.

        Returns
        -------
        data : bytes
        """
        return pack(self._fields(), self.identifier)

    @classmethod
    def from_bytes(cls, data: bytes, origin: str = "the model") -> ShapeModel:
        """Rebuild a model from `to_bytes`.

        Parameters
        ----------
        data : bytes
            Content of a model file.
        origin : str, optional
            Name of the model in error messages.

        Returns
        -------
        model : ShapeModel

        Raises
        ------
        ModelError
            If the data is not a model, is damaged, or has a newer format.
        """
        with damage_refused(origin):
            entries, identifier = unpack(data, origin)
            model = cls(**entries)
        # In the place of the cached property, so that a changed copy of the model gets one of its own.
        vars(model)["identifier"] = identifier
        return model

    def save(self, path: str | Path) -> None:
        """Write the model to a file.

        Parameters
        ----------
        path : str or Path
            By convention with the suffix ``.npz``.

        Raises
        ------
        ModelError
            If the file cannot be written.
        """
        try:
            Path(path).write_bytes(self.to_bytes())
        except OSError as error:
            raise ModelError(f"cannot write the model {str(path)!r}: {error.strerror}") from error
