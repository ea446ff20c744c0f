# SPDX-License-Identifier: MIT
"""Baselines from before Shape Google: one description of each whole shape."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import Self, TypeVar

import numpy as np
from scipy.spatial.distance import cdist

from benchmarks.protocol.cache import (
    Arrays,
    BenchmarkCache,
    cached_shape,
    code_digest,
    digest,
    preparation_of,
)
from benchmarks.protocol.collection import BenchmarkShape
from benchmarks.protocol.matching import Matched, Variant, between, median_seconds, stacked
from benchmarks.protocol.workshop import Source, Task, Workshop
from benchmarks.variants.bag_variants import Preparation
from benchmarks.variants.baselines import (
    d2_distribution,
    diffusion_distances,
    gps_distances,
    shape_dna,
    surface_moments,
)
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.spectral import Spectrum

__all__ = ["BaselineGroup", "mesh_groups", "spectrum_groups"]


@dataclass(frozen=True)
class _SpectrumTask:
    """Describes a shape by its spectrum."""

    name: str
    describe: Callable[[Spectrum], FloatArray]
    preparation: Preparation
    seed: int
    kind: str = "baselines"

    @property
    def title(self) -> str:
        return f"{self.name}, {self.preparation.name}"

    @property
    def key(self) -> str:
        return digest(self.name, self.seed, preparation_of(self.preparation.settings), code_digest(_CODE))

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        spectrum = cached_shape(cache, self.preparation.settings, source.key, source.mesh).spectrum
        return _timed(self.describe, spectrum)


@dataclass(frozen=True)
class _MeshTask:
    """Describes a shape by its mesh as read."""

    name: str
    describe: Callable[[Mesh], FloatArray]
    seed: int
    kind: str = "baselines"

    @property
    def title(self) -> str:
        return self.name

    @property
    def key(self) -> str:
        return digest(self.name, self.seed, code_digest(_CODE))

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        del cache  # it needs no spectrum
        return _timed(self.describe, source.mesh())


_CODE = (
    "benchmarks/variants/baselines.py",
    "benchmarks/variants/baseline_variants.py",
    "shapegoogle_core/descriptors/spectral.py",
)

T = TypeVar("T")


def _timed(describe: Callable[[T], FloatArray], shape: T) -> Arrays:
    started = time.process_time()
    description = describe(shape)
    return {"description": description, "seconds": np.array(time.process_time() - started)}


@dataclass(frozen=True, eq=False)
class BaselineGroup:
    """One description of a whole shape, compared by one metric of `scipy.spatial.distance.cdist`."""

    task: Task
    metric: str
    variants: tuple[Variant, ...]

    def only(self, names: set[str]) -> Self:
        """Return the group without the variants of other names."""
        chosen = tuple(variant for variant in self.variants if variant.name in names)
        return type(self)(self.task, self.metric, chosen)

    def match(
        self, workshop: Workshop, queries: Sequence[BenchmarkShape], database: Sequence[BenchmarkShape]
    ) -> Iterator[Matched]:
        """Compare all queries with the database."""
        entries = [workshop.describe(self.task, shapes) for shapes in (database, queries)]
        known, asked = (stacked(described, "description") for described in entries)
        cost = median_seconds(chain(*entries))
        for variant in self.variants:
            yield between(variant, self._distances, asked, known, 4 * known.shape[1], cost)

    def _distances(self, first: FloatBags, second: FloatBags) -> FloatArray:
        metric = self.metric
        if metric == "euclidean":
            return np.asarray(cdist(first, second, "euclidean"), np.float64)
        return np.asarray(cdist(first, second, "cityblock"), np.float64)


def spectrum_groups(preparation: Preparation, seed: int) -> list[BaselineGroup]:
    """Make Shape-DNA, compared by Euclidean distance, and histograms of distances, compared by L1 distance.

    Parameters
    ----------
    preparation : Preparation
        Preprocessing and spectra of the shapes.
    seed : int
        Of the pairs of points.

    Returns
    -------
    groups : list of BaselineGroup
        One variant each.
    """
    place = "" if preparation.name == "paper" else f" · {preparation.name}"
    groups = []
    for name, describe, metric in (
        ("Shape-DNA", shape_dna, "euclidean"),
        ("diffusion distances", partial(diffusion_distances, seed=seed), "cityblock"),
        ("GPS distances", partial(gps_distances, seed=seed), "cityblock"),
    ):
        parameters: dict[str, str | int | float] = {"descriptor": name, "preparation": preparation.name}
        variant = Variant(name + place, "baseline", parameters, headline=not place)
        groups.append(BaselineGroup(_SpectrumTask(name, describe, preparation, seed), metric, (variant,)))
    return groups


def mesh_groups(seed: int) -> list[BaselineGroup]:
    """Make D2 distributions and moments of the meshes as read, compared by L1 distance.

    Parameters
    ----------
    seed : int
        Of the points of D2.

    Returns
    -------
    groups : list of BaselineGroup
        One variant each.
    """
    groups = []
    for name, descriptor, describe in (
        ("D2 distribution", "D2", partial(d2_distribution, seed=seed)),
        ("moments", "moments", surface_moments),
    ):
        variant = Variant(name, "baseline", {"descriptor": descriptor}, headline=True)
        groups.append(BaselineGroup(_MeshTask(name, describe, seed), "cityblock", (variant,)))
    return groups
