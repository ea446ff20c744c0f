# SPDX-License-Identifier: MIT
"""Settings of a model: every choice of the method in one place."""

from __future__ import annotations

import inspect
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

import numpy as np

from shapegoogle_core.api.registry import Registry
from shapegoogle_core.descriptors import DESCRIPTORS
from shapegoogle_core.errors import ModelError
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.laplacian import BOUNDARIES, LAPLACIANS
from shapegoogle_core.mesh.mesh import Mesh
from shapegoogle_core.preprocessing import PreprocessingSettings
from shapegoogle_core.registration.local_words import LocalSettings
from shapegoogle_core.registration.sample import SampleSettings
from shapegoogle_core.spectral import Spectrum

__all__ = ["BAGS", "COUNTING_BAGS", "DESCRIPTORS", "ChannelSettings", "ModelSettings"]


def _check_choice(name: str, choice: str, choices: Collection[str]) -> None:
    if choice not in choices:
        hint = "; if a plug-in has it, install its package" if isinstance(choices, Registry) else ""
        raise ModelError(f"{name} must be one of {', '.join(choices)}, not {choice!r}{hint}")


def _check(right: bool, name: str, wanted: str, value: object) -> None:
    if not right:
        raise ModelError(f"{name} must be {wanted}, not {value!r}")


CODE_DIRECTIONS = ("eigenvectors", "random", "rotated")

BAGS = ("area", "plain", "pairs", "plain-pairs")
"""Kinds of bags: of words or of pairs of words, weighted by area or counting all vertices equally."""

COUNTING_BAGS = ("plain", "plain-pairs")
"""Kinds that count all vertices equally, for detected points, which have no area."""


@dataclass(frozen=True)
class ChannelSettings:
    """Settings of one channel: a descriptor, its vocabulary and its bags.

    Attributes
    ----------
    descriptor : str
        A key of `DESCRIPTORS`.
    parameters : mapping
        Parameters of the descriptor. Times of heat kernels are in squared units of the shape after scaling to
        `ModelSettings.area`; all other lengths and times are relative to the area.
    words : int
        Size V of the vocabulary.
    soft : bool
        Soft (paper, equation 12) or hard quantisation.
    bags : tuple of str
        Kinds of bags, some of `BAGS`.
    pair_time : float
        Time t of the kernel in bags of pairs (paper, equation 16), in the same unit as the times.
    sigma_factor : float
        σ of the soft words, as a multiple of the median distance of a descriptor from its nearest word.
    detector : str or None
        A key of `shapegoogle_core.keypoints.DETECTORS`, to count only detected points (paper, algorithm 2,
        lines 1 to 4), in "plain" bags. None counts all vertices.

    Raises
    ------
    ModelError
        If a choice does not exist, a value is out of range, or the descriptor rejects its parameters.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> channel = sg.ChannelSettings("hks", {"times": (0.001, 0.01, 0.1)}, words=8)
    >>> channel.size, channel.bag_sizes()
    (3, [8, 36])
    """

    descriptor: str
    parameters: Mapping[str, Any]
    words: int = 48
    soft: bool = True
    bags: tuple[str, ...] = ("area", "pairs")
    pair_time: float = 0.0256
    sigma_factor: float = 2.0
    detector: str | None = None

    def __post_init__(self) -> None:
        _check_choice("descriptor", self.descriptor, DESCRIPTORS)
        if not self.bags or not set(self.bags) <= set(BAGS):
            raise ModelError(f"bags must be some of {', '.join(BAGS)}, not {self.bags}")
        if self.detector is not None:
            _check_choice("detector", self.detector, DETECTORS)
            if not set(self.bags) <= set(COUNTING_BAGS):
                raise ModelError(
                    f"detected points have no area: with a detector, bags must be some of "
                    f"{', '.join(COUNTING_BAGS)}, not {self.bags}"
                )
        _check(self.words >= 1, "words", "at least 1", self.words)
        _check(0 <= self.pair_time < math.inf, "pair_time", "a time ≥ 0", self.pair_time)
        _check(0 < self.sigma_factor < math.inf, "sigma_factor", "positive", self.sigma_factor)
        known = list(inspect.signature(DESCRIPTORS[self.descriptor]).parameters.values())[2:]
        names = [parameter.name for parameter in known]
        needed = [parameter.name for parameter in known if parameter.default is parameter.empty]
        try:
            if unknown := set(self.parameters) - set(names):
                raise ValueError(f"it has no {', '.join(sorted(unknown))}, only {', '.join(names)}")
            if missing := [name for name in needed if name not in self.parameters]:
                raise ValueError(f"it needs {', '.join(missing)}, which have no defaults")
            self.size  # noqa: B018 (tries the parameters)
        except ValueError as error:
            raise ModelError(f"parameters of {self.descriptor!r} do not work: {error}") from error
        except TypeError as error:
            raise ModelError(
                f"parameters of {self.descriptor!r} do not work: they must be numbers"
            ) from error

    @property
    def size(self) -> int:
        """Number d of values of the descriptor at a vertex."""
        tetrahedron = Mesh(np.eye(4, 3), [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]], "a tetrahedron")
        spectrum = Spectrum(np.array([0.0, 1.0, 2.0]), np.eye(4, 3), np.ones(4))
        return int(DESCRIPTORS[self.descriptor](tetrahedron, spectrum, **self.parameters).shape[1])

    def bag_sizes(self) -> list[int]:
        """Compute the length of each bag; a bag of pairs is symmetric and keeps only its upper triangle.

        Returns
        -------
        sizes : list of int
        """
        pairs = self.words * (self.words + 1) // 2
        return [pairs if "pairs" in bag else self.words for bag in self.bags]


@dataclass(frozen=True)
class ModelSettings:
    """Settings of a model: every choice between a mesh and its signature.

    Attributes
    ----------
    name : str
        Name of the preset, shown to users.
    channels : tuple of ChannelSettings
        Channels, whose bags stand side by side.
    preprocessing : PreprocessingSettings or None
        Preprocessing of a mesh; None: it is only repaired.
    area : float
        Every shape is scaled to this area first, in squared units: the search forgets the size.
    laplacian : str
        A key of `shapegoogle_core.laplacian.LAPLACIANS`. Point clouds always have "point-cloud".
    boundary : {"neumann", "dirichlet"}
        Condition on open boundaries, see `compute_spectrum`. Heat is 0 on a Dirichlet boundary, so that
        descriptors there carry no information.
    eigenpairs : int
        Number k of eigenpairs of the spectrum.
    square_root : bool
        Whether to take the square root of all bags (Hellinger), so that frequent words do not outweigh rare
        ones.
    inverse_document_frequency : bool
        Whether to weight words and pairs by tf-idf (paper, equations 17 and 18).
    projected : int
        Dimension of the learnt projection in which bags are compared and hashed.
    shrinkage : float
        Shrinkage of the learnt metric towards plain principal components, from 0 to 1.
    metric : {"cosine", "l1"}
        Compare bags by the cosine of their projections, or by the L1 distance of the bags themselves
        (the paper's).
    code_bits : int
        Length of the binary code, a multiple of 8.
    code_directions : {"eigenvectors", "random", "rotated"}
        Origin of the candidates for the directions of the code, see `SimilaritySensitiveHashing`; "rotated"
        uses the directions of `rotated_components`, which are not learnt from pairs.
    sample : SampleSettings or None
        Size of the samples with which a search aligns the best candidates with the query. None compares
        candidates by their bags alone.
    local : LocalSettings or None
        Size of the index of parts, which is made from the samples. None takes candidates from the codes
        alone.

    Raises
    ------
    ModelError
        If a choice does not exist or a value is out of range.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> settings = sg.load_model().settings
    >>> [channel.descriptor for channel in settings.channels]
    ['hks', 'log-hks', 'si-hks']
    >>> settings.bag_size
    2700
    >>> settings.with_descriptors(["log-hks"]).bag_size
    900
    """

    name: str
    channels: tuple[ChannelSettings, ...]
    preprocessing: PreprocessingSettings | None = field(default_factory=PreprocessingSettings)
    area: float = 1.0
    laplacian: str = "robust"
    boundary: str = "neumann"
    eigenpairs: int = 100
    square_root: bool = True
    inverse_document_frequency: bool = False
    projected: int = 400
    shrinkage: float = 0.05
    metric: str = "cosine"
    code_bits: int = 256
    code_directions: str = "eigenvectors"
    sample: SampleSettings | None = None
    local: LocalSettings | None = None

    def __post_init__(self) -> None:
        if not self.channels:
            raise ModelError("a model needs at least one channel")
        _check_choice("laplacian", self.laplacian, LAPLACIANS)
        _check_choice("boundary", self.boundary, BOUNDARIES)
        _check_choice("code_directions", self.code_directions, CODE_DIRECTIONS)
        _check_choice("metric", self.metric, ("cosine", "l1"))
        bits = self.code_bits
        _check(bits > 0 and bits % 8 == 0, "code_bits", "a positive multiple of 8", bits)
        _check(self.eigenpairs >= 1, "eigenpairs", "at least 1", self.eigenpairs)
        _check(0 < self.area < math.inf, "area", "positive", self.area)
        _check(self.projected >= 1, "projected", "at least 1", self.projected)
        _check(0 <= self.shrinkage <= 1, "shrinkage", "from 0 to 1", self.shrinkage)
        if self.local is not None and self.sample is None:
            raise ModelError("local words are made from samples: settings with `local` also need `sample`")

    @property
    def bag_size(self) -> int:
        """Length B of all bags side by side."""
        return sum(sum(channel.bag_sizes()) for channel in self.channels)

    def with_descriptors(self, names: Sequence[str]) -> ModelSettings:
        """Choose other descriptors.

        Parameters
        ----------
        names : sequence of str
            Keys of `DESCRIPTORS`, one for each channel.

        Returns
        -------
        settings : ModelSettings
            Descriptors that these settings have keep their channels. Others get their default parameters, and
            words and bags as the first channel.

        Raises
        ------
        ModelError
            If a name is unknown, or another descriptor has no default parameters.
        """
        known = {channel.descriptor: channel for channel in self.channels}
        return replace(
            self,
            channels=tuple(
                known[name] if name in known else replace(self.channels[0], descriptor=name, parameters={})
                for name in names
            ),
        )

    def to_dict(self) -> dict[str, Any]:
        """Convert to nested dicts for JSON; see `from_dict`.

        Returns
        -------
        values : dict
            Without `sample`, `local` and `detector` where they are None, without `boundary` where it is
            "neumann", and without `longest_edge` where it is 0: models from before these existed keep their
            identifier. For the same reason the key of `preprocessing` is its former name, "mending".
        """
        values = {"mending" if key == "preprocessing" else key: value for key, value in asdict(self).items()}
        later: list[tuple[dict[str, Any], str, object]] = [
            (values, "sample", None),
            (values, "local", None),
            (values, "boundary", "neumann"),
        ]
        later += [(channel, "detector", None) for channel in values["channels"]]
        if values["mending"] is not None:
            later.append((values["mending"], "longest_edge", 0.0))
        for choices, name, before in later:
            if choices[name] == before:
                del choices[name]
        return values

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> ModelSettings:
        """Rebuild settings from `to_dict`, for example out of JSON.

        Parameters
        ----------
        values : mapping
            Nested mappings from `to_dict`.

        Returns
        -------
        settings : ModelSettings

        Raises
        ------
        ModelError
            If something is missing, unknown or out of range.
        """
        try:
            known = dict(values)
            if "mending" in known:
                known["preprocessing"] = known.pop("mending")
            if missing := {"name", "channels", "preprocessing"} - set(known):
                raise ModelError(
                    f"the settings of the model are damaged: {', '.join(sorted(missing))} is missing; "
                    "copy or train the model again"
                )
            if known["preprocessing"] is not None:
                known["preprocessing"] = PreprocessingSettings(
                    # Earlier models kept the triangles of a mesh as they were.
                    **{"longest_edge": 0.0, **known["preprocessing"]}
                )
            unknown = set(known) - {entry.name for entry in fields(cls)}
            if unknown:
                raise ModelError(f"unknown settings {', '.join(sorted(unknown))}; update Shape Google")
            known["channels"] = tuple(
                ChannelSettings(**{**channel, "bags": tuple(channel["bags"])})
                for channel in known["channels"]
            )
            if known.get("sample") is not None:
                known["sample"] = SampleSettings(**known["sample"])
            if known.get("local") is not None:
                # Earlier models also have "bits", of codes that are no longer used.
                known["local"] = LocalSettings(words=known["local"]["words"])
            return cls(**known)
        except (KeyError, TypeError, ValueError) as error:
            raise ModelError("the settings of the model are damaged; copy or train it again") from error
