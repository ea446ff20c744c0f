# SPDX-License-Identifier: MIT
"""Computations for each shape of the paper's variants: descriptors to learn from, and bags."""

from __future__ import annotations

import time
import zlib
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from benchmarks.protocol.cache import (
    PREPARATION_CODE,
    Arrays,
    BenchmarkCache,
    cached_shape,
    code_digest,
    digest,
    preparation_of,
)
from benchmarks.protocol.workshop import Source
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ModelSettings
from shapegoogle_core.model.settings import DESCRIPTORS
from shapegoogle_core.model.shape_bags import counted_points
from shapegoogle_core.model.working_shape import WorkingShape
from shapegoogle_core.words import bag_of_features, hard_words, soft_words, spatially_sensitive_bag

__all__ = ["BagKey", "BagsTask", "Descriptor", "Preparation", "SampleTask", "Vocabularies"]

BagKey = tuple[int, str, str]
"""Words of the vocabulary, kind of `BAGS`, and detector of the points that count, "" for all vertices."""

_SAMPLED_VERTICES = 100  # of each version, to learn vocabularies from


@dataclass(frozen=True)
class Preparation:
    """Preprocessing and spectrum of meshes.

    Attributes
    ----------
    name : str
    settings : ModelSettings
        Only its preprocessing, area, Laplacian and number of eigenpairs matter.
    """

    name: str
    settings: ModelSettings


@dataclass(frozen=True)
class Descriptor:
    """A local descriptor.

    Attributes
    ----------
    name : str
        In the table.
    kind : str
        A key of `shapegoogle_core.model.settings.DESCRIPTORS`.
    parameters : dict
        Of it.
    pair_time : float
        t of the kernel in bags of pairs.
    without_waves : tuple of float
        Values at every vertex of a shape whose eigenvalues are all 0, if the descriptor needs positive ones.
        A polygon soup with more parts than eigenpairs, as many shapes of PSB are, is such a shape; with these
        values it is compared like any other shape and not ranked last.
    """

    name: str
    kind: str
    parameters: dict[str, Any]
    pair_time: float
    without_waves: tuple[float, ...] = ()

    @property
    def key(self) -> str:
        """Digest of everything its values depend on."""
        return digest(self.kind, self.parameters, code_digest(("shapegoogle_core/descriptors",)))

    def values(self, shape: WorkingShape, name: str) -> FloatArray:
        """Compute the descriptor of every vertex.

        Parameters
        ----------
        shape : WorkingShape
        name : str
            Of the shape, for errors.

        Returns
        -------
        values : (n, d) array

        Raises
        ------
        MeshError
            If the shape has no such descriptor.
        """
        spectrum = shape.spectrum
        if self.without_waves and not spectrum.eigenvalues.any():
            return np.tile(self.without_waves, (len(spectrum.mass), 1))
        try:
            return DESCRIPTORS[self.kind](shape.mesh, spectrum, **self.parameters)
        except ValueError as error:
            raise MeshError(f"{name!r} has no {self.name}: {error}") from error


Vocabularies = dict[int, Arrays]
"""By their number of words: "centers" (V, d) and "sigma" ()."""


@dataclass(frozen=True)
class SampleTask:
    """Computes descriptors at some vertices of a shape."""

    preparation: Preparation
    descriptor: Descriptor
    kind: str = "samples"

    @property
    def title(self) -> str:
        """Description in the progress bar."""
        return f"{self.descriptor.name}, {self.preparation.name}: descriptors to learn from"

    @property
    def key(self) -> str:
        """Digest of everything its values depend on besides the shape."""
        return digest(preparation_of(self.preparation.settings), self.descriptor.key, _SAMPLED_VERTICES)

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        """Compute "descriptors" (s, d) of a shape."""
        shape = cached_shape(cache, self.preparation.settings, source.key, source.mesh)
        # A seed of the name's own, so that the choice does not depend on the code's digest.
        random = np.random.default_rng(zlib.crc32(source.name.encode()))
        chosen = random.permutation(len(shape.mesh.vertices))[:_SAMPLED_VERTICES]
        return {"descriptors": self.descriptor.values(shape, source.name)[chosen]}


@dataclass(frozen=True)
class BagsTask:
    """Computes bags of a shape for several vocabularies, concatenated in one array."""

    preparation: Preparation
    descriptor: Descriptor
    vocabularies: Vocabularies
    bags: tuple[BagKey, ...]
    hard: bool = False
    kind: str = "bags"

    @property
    def title(self) -> str:
        """Description in the progress bar."""
        to_learn = " to learn from" if self.hard else ""
        return f"{self.descriptor.name}, {self.preparation.name}: bags{to_learn}"

    @property
    def key(self) -> str:
        """Digest of everything its values depend on besides the shape."""
        vocabularies = [
            [words, entry["centers"], entry["sigma"]] for words, entry in sorted(self.vocabularies.items())
        ]
        code = code_digest(
            ("shapegoogle_core/words", "shapegoogle_core/keypoints", "benchmarks/variants/bag_tasks.py")
        )
        chosen = [self.bags, self.descriptor.pair_time, self.hard]
        return digest(
            preparation_of(self.preparation.settings), self.descriptor.key, vocabularies, chosen, code
        )

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        """Compute "bags", see `slices`, "hard" bags, and the "seconds" of the descriptor."""
        shape = cached_shape(cache, self.preparation.settings, source.key, source.mesh)
        started = time.process_time()
        values = self.descriptor.values(shape, source.name)
        seconds = time.process_time() - started
        spectrum = shape.spectrum
        points = self._points(shape, source, cache)
        computed: dict[str, list[FloatArray]] = {"bags": [], "hard": []}
        for name, parts in computed.items():
            if name == "hard" and not self.hard:
                continue
            for size, vocabulary in self.vocabularies.items():
                centers = vocabulary["centers"]
                if name == "hard":
                    words = hard_words(values, centers)
                else:
                    words = soft_words(values, centers, float(vocabulary["sigma"]))
                upper, double = np.triu_indices(size), 2 - np.eye(size)
                for _, bag, detector in (chosen for chosen in self.bags if chosen[0] == size):
                    by_area = bag in ("area", "pairs")
                    there, counted = words, spectrum
                    if detector:
                        there, counted = words[points[detector]], spectrum.at(points[detector])
                    if "pairs" in bag:
                        pairs = spatially_sensitive_bag(
                            there, counted, self.descriptor.pair_time, area_weighted=by_area
                        )
                        parts.append((double * pairs)[upper])
                    else:
                        parts.append(bag_of_features(there, counted.mass if by_area else None))
        bags = {name: np.concatenate(parts).astype(np.float32) for name, parts in computed.items() if parts}
        return {**bags, "seconds": np.array(seconds)}

    def _points(self, shape: WorkingShape, source: Source, cache: BenchmarkCache) -> Arrays:
        """Detect keypoints with each detector of the bags."""
        detectors = sorted({detector for _, _, detector in self.bags} - {""})
        if not detectors:
            return {}
        settings = self.preparation.settings

        def detect() -> Arrays:
            return {one: counted_points(shape.mesh, shape.spectrum, one) for one in detectors}

        code = code_digest((*PREPARATION_CODE, "shapegoogle_core/keypoints"))
        return cache.remembered(
            "keypoints", digest(source.key, preparation_of(settings), detectors, code), detect
        )

    def slices(self) -> dict[BagKey, slice]:
        """Return the slice of each bag in the array."""
        order = [chosen for size in self.vocabularies for chosen in self.bags if chosen[0] == size]
        sizes = [size * (size + 1) // 2 if "pairs" in bag else size for size, bag, _ in order]
        ends = pairwise(accumulate(sizes, initial=0))
        return {chosen: slice(*span) for chosen, span in zip(order, ends, strict=True)}
