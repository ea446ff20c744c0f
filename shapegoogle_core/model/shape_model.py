# SPDX-License-Identifier: MIT
"""`ShapeModel`: from a mesh to its signature, and from signatures to similarities (paper, figure 2)."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.model.background import Background
from shapegoogle_core.model.comparison import BagComparison
from shapegoogle_core.model.model_file import (
    arrays_of,
    check_learnt,
    damage_refused,
    identifier_of,
    pack,
    unpack,
)
from shapegoogle_core.model.ranking import Ranking
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.model.shape_bags import ChannelWords, FloatBags, shape_bags
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.registration import LocalWords, measure_mesh, sample_surface
from shapegoogle_core.views import ViewModel

__all__ = ["ShapeModel"]


@dataclass(frozen=True, eq=False, repr=False)
class ShapeModel(BagComparison):
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
    background : Background or None
        Unlike shapes that tell how distinctive an agreement is.
    ranking : Ranking or None
        What orders shapes of the same kind.

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
    background: Background | None = None
    ranking: Ranking | None = None

    def __post_init__(self) -> None:
        check_learnt(self)

    def __repr__(self) -> str:
        return f"ShapeModel({self.name!r}, {self.identifier})"

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
        Mesh('mesh', 1034 vertices, 2064 faces)
        """
        mesh = as_mesh(mesh)
        # On matrices of this size a second BLAS thread only doubles the processor time.
        with threadpool_limits(1, user_api="blas"):
            shape = working_shape(self.settings, mesh)
            bags = shape_bags(self.settings, self.vocabularies, shape) * self.weights
            code = self.codes(bags[None])[0]
            sample = local_code = None
            if self.settings.sample is not None:
                sample = sample_surface(shape.mesh, shape.spectrum, self.settings.sample, shape.unsmoothed)
                sample = sample.moved_back(shape.placement.origin, shape.placement.scale)
            if sample is not None and self.local_words is not None:
                local_code = self.local_words.code(sample)
            views = None if self.views is None else self.views.describe(mesh)
            measures = measure_mesh(mesh)
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
            measures=measures,
            surface=shape.placement.restore(shape.mesh) if keep_surface and not cloud else None,
            views=views,
            view_code=None if self.views is None or views is None else self.views.code(views),
        )

    def with_parts(
        self,
        *,
        views: ViewModel | None = None,
        background: Background | None = None,
        ranking: Ranking | None = None,
    ) -> ShapeModel:
        """Exchange parts of the model that say nothing about bags; its identifier stays.

        Parameters
        ----------
        views : ViewModel, optional
            How shapes look from outside. Parts that are left out stay as they are.
        background : Background, optional
            Unlike shapes that agreements are compared with.
        ranking : Ranking, optional
            Order of shapes of a kind.

        Returns
        -------
        model : ShapeModel
        """
        changed = replace(
            self,
            views=views or self.views,
            background=background or self.background,
            ranking=ranking or self.ranking,
        )
        # In the place of the cached property: the file of an early model states another than it has by now.
        vars(changed)["identifier"] = self.identifier
        return changed

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
