# SPDX-License-Identifier: MIT
"""A trained Shape Google: from a mesh to its signature (paper, figure 2 and algorithm 2)."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.distances import row_distances
from shapegoogle_core.model.model_file import (
    arrays_of,
    damage_refused,
    identifier_of,
    pack,
    read_file,
    unpack,
)
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.model.shape_bags import ChannelWords, FloatBags, channel_words, shape_bags
from shapegoogle_core.model.signature import ShapeSignature, WordMap
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.registration import LocalWords, sample_surface

__all__ = ["ShapeModel", "load_model"]


@dataclass(frozen=True, eq=False, repr=False)
class ShapeModel:
    """All that is learnt, and the settings it was learnt with.

    Attributes
    ----------
    settings : ModelSettings
    vocabularies : tuple of ChannelWords
        One for each channel.
    weights : (B,) array of float32
        Of tf-idf, for each entry of the bags; ones where it is not used.
    mean : (B,) array of float32
        Mean of the training bags.
    projection : (B, p) array of float16
        The learnt metric: bags are compared and hashed as (f - mean) @ projection.
    directions : (s, p) array of float32
        A of the code y = sign(A f + b) (paper, equation 19), f projected and of unit length.
    thresholds : (s,) array of float32
        b.
    similarity_half, similarity_slope : float
        Calibration of `similarity`: the distance at which it is ½, and how fast it falls there.
    trained_on : str
        A sentence on the training shapes.
    agreement_gain : float
        How much an agreement in space says, see `verified_distance`.
    verified_half, verified_slope : float
        Calibration of the similarity of verified distances.
    local_words : LocalWords or None
        The index of parts, if `settings.local` asks for one.
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

    def __post_init__(self) -> None:
        size, projected, bits = self.bag_size, self.projection.shape[-1], self.code_bits
        expected = {
            "weights": (size,),
            "mean": (size,),
            "projection": (size, projected),
            "directions": (bits, projected),
            "thresholds": (bits,),
        }
        for name, shape in expected.items():
            array = getattr(self, name)
            if array.shape != shape or not np.isfinite(array).all():
                raise ModelError(f"the model's {name} are damaged: expected finite numbers of shape {shape}")
        for channel, words in zip(self.settings.channels, self.vocabularies, strict=True):
            fits = words.centers.shape == (channel.words, channel.size)
            if not (fits and np.isfinite(words.centers).all() and 0 < words.sigma < np.inf):
                raise ModelError(f"the model's vocabulary of {channel.descriptor!r} is damaged")
        calibration = (
            self.similarity_half,
            self.similarity_slope,
            self.verified_half,
            self.verified_slope,
        )
        if not all(0 < value < np.inf for value in calibration):
            raise ModelError("the model's calibration of similarities is damaged")
        if not 0 <= self.agreement_gain < np.inf:
            raise ModelError("the model's agreement_gain is damaged: it must be a number ≥ 0")
        local = None if self.settings.local is None else self.settings.local.words
        if local != (None if self.local_words is None else len(self.local_words.weights)):
            raise ModelError("the model's local words are damaged: they are not of the size in its settings")

    def __repr__(self) -> str:
        return f"ShapeModel({self.name!r}, {self.identifier})"

    @property
    def bag_size(self) -> int:
        """B, the length of all bags side by side."""
        return self.settings.bag_size

    @property
    def code_bits(self) -> int:
        """The length of the binary code."""
        return self.settings.code_bits

    @property
    def name(self) -> str:
        """The preset's name, for people; `identifier` tells models apart."""
        return self.settings.name

    @cached_property
    def identifier(self) -> str:
        """16 hexadecimal digits, equal only for models whose signatures can be compared."""
        return identifier_of(self.settings.to_dict(), arrays_of(self._fields()), self.agreement_gain)

    def describe(self, mesh: Mesh, *, keep_surface: bool = False) -> ShapeSignature:
        """Compute the signature of a shape.

        Parameters
        ----------
        mesh : Mesh
            As read: any resolution, size and state of repair; or points without faces, at least ten.
        keep_surface : bool, optional
            Put the mended mesh into the signature too: evidence of matches is measured on it. Of points
            without faces there is none, and the evidence is coarser.

        Returns
        -------
        signature : ShapeSignature

        Raises
        ------
        MeshError
            If the mesh has no surface, or its points are none of a surface.
        """
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
            surface=shape.placement.restore(shape.mesh) if keep_surface and not cloud else None,
        )

    def word_map(self, mesh: Mesh, channel: int = 0) -> WordMap:
        """Show which word each part of a shape is.

        Parameters
        ----------
        mesh : Mesh
        channel : int
            Which of the model's channels.

        Returns
        -------
        word_map : WordMap
            On the mended mesh.

        Raises
        ------
        MeshError
            If the mesh has no surface.
        """
        shape = working_shape(self.settings, mesh)
        words = channel_words(self.settings, channel, self.vocabularies[channel], shape)
        return WordMap(shape.mesh, words)

    def embed(self, bags: FloatBags) -> FloatBags:
        """Project bags into the space of the learnt metric.

        Parameters
        ----------
        bags : (n, B) array

        Returns
        -------
        vectors : (n, p) array of float32
            Of unit length.
        """
        vectors = (np.asarray(bags, np.float32) - self.mean) @ self._projection
        vectors /= np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(np.float32).tiny)
        return np.asarray(vectors, dtype=np.float32)

    def codes(self, bags: FloatBags) -> NDArray[np.uint8]:
        """Binary codes y = sign(A f + b) of bags (paper, equation 19).

        Parameters
        ----------
        bags : (n, B) array

        Returns
        -------
        codes : (n, s/8) array of uint8
            Packed as by `numpy.packbits`.
        """
        return np.packbits(self.code_projections(bags) > 0, axis=1)

    def code_projections(self, bags: FloatBags, embedded: FloatBags | None = None) -> FloatBags:
        """Projections A f + b, whose signs are the codes.

        Parameters
        ----------
        bags : (n, B) array
        embedded : (n, p) array, optional
            f: what `embed` makes of them, where it is known.

        Returns
        -------
        projections : (n, s) array of float32
        """
        embedded = self.embed(bags) if embedded is None else embedded
        return np.asarray(embedded @ self.directions.T + self.thresholds, np.float32)

    def comparable(self, bags: FloatBags, embedded: FloatBags | None = None) -> FloatBags:
        """Vectors between which `row_distances` is this model's distance.

        Parameters
        ----------
        bags : (n, B) array
        embedded : (n, p) array, optional
            What `embed` makes of them, where it is known.

        Returns
        -------
        vectors : (n, p) or (n, B) array of float32
            "cosine": projected. "l1": the bags, divided by how many stand side by side.
        """
        if self.settings.metric == "cosine":
            return self.embed(bags) if embedded is None else embedded
        count = sum(len(channel.bags) for channel in self.settings.channels)
        return np.asarray(bags, np.float32) / np.float32(count)

    def distances(self, query: FloatBags, bags: FloatBags) -> FloatArray:
        """Distance of one shape's bags to others', as `settings.metric` says.

        Parameters
        ----------
        query : (B,) array
        bags : (n, B) array

        Returns
        -------
        distances : (n,) array
            ≥ 0. "cosine": 1 - cos of the projections. "l1": Σ|f - f'|, averaged over the bags.
        """
        return row_distances(self.settings.metric, self.comparable(query[None]), self.comparable(bags))

    def verified_distance(self, distance: float, excess: float) -> float:
        """Lower the distance of bags by what two surfaces have in common in space.

        d′ = d exp(-k e). The logistic regression behind `similarity` is linear in log d; with the excess e as
        its second variable, k is the ratio of both coefficients (see `metric.calibrate`).

        Parameters
        ----------
        distance : float
            From `distances`.
        excess : float
            e, see `Alignment.excess`.

        Returns
        -------
        distance : float
            d′ ≤ d. No agreement leaves it as it is: bags alone find other poses.
        """
        return distance * math.exp(-self.agreement_gain * excess)

    def similarity(self, distances: FloatArray, *, verified: bool = False) -> FloatArray:
        """Turn distances into a similarity from 0 to 1.

        s(d) = 1 / (1 + (d / d_½)^p), fitted on training shapes by logistic regression: the probability that
        a shape at distance d is the same one transformed rather than the nearest of fifty different ones, if
        either is as likely beforehand.

        Parameters
        ----------
        distances : (n,) array
        verified : bool
            Whether agreements in space have lowered the distances. A distance that none has lowered then says
            less than one of bags alone: nothing was found to agree.

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

    @cached_property
    def _projection(self) -> FloatBags:
        return self.projection.astype(np.float32)

    def _fields(self) -> dict[str, object]:
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}

    def to_bytes(self) -> bytes:
        """Serialise: a numpy .npz archive whose entry `header` is JSON; nothing is pickled."""
        return pack(self._fields(), self.identifier)

    @classmethod
    def from_bytes(cls, data: bytes, origin: str = "the model") -> ShapeModel:
        """Rebuild a model from `to_bytes`.

        Parameters
        ----------
        data : bytes
        origin : str
            What errors call the model: its file.

        Returns
        -------
        model : ShapeModel

        Raises
        ------
        ModelError
            If the data is no model, damaged, or of a newer version.
        """
        with damage_refused(origin):
            entries, identifier = unpack(data, origin)
            model = cls(**entries)
        # In the place of the cached property, so that a changed copy of the model gets one of its own.
        vars(model)["identifier"] = identifier
        return model

    def save(self, path: str | Path) -> None:
        """Write the model to a file, by convention `.npz`.

        Parameters
        ----------
        path : str or Path

        Raises
        ------
        ModelError
            If the file cannot be written.
        """
        try:
            Path(path).write_bytes(self.to_bytes())
        except OSError as error:
            raise ModelError(f"cannot write the model {str(path)!r}: {error.strerror or error}") from error


def load_model(path: str | Path | None = None) -> ShapeModel:
    """Load a model.

    Parameters
    ----------
    path : str or Path, optional
        A model file, or the name of a shipped model: "default" (also when left out) or "paper".

    Returns
    -------
    model : ShapeModel

    Raises
    ------
    ModelError
        If there is no such file, or it is no model.
    """
    return ShapeModel.from_bytes(*read_file(path))
