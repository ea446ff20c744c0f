# SPDX-License-Identifier: MIT
"""What was there before Shape Google, as rows of the benchmark: Shape-DNA and the D2 distribution."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.spatial.distance import cdist

from shapegoogle_core.describing import FloatBags
from shapegoogle_core.evaluation.bag_variants import Preparation
from shapegoogle_core.evaluation.baselines import d2_distribution, shape_dna
from shapegoogle_core.evaluation.collection import BenchmarkShape
from shapegoogle_core.evaluation.matching import Matched, Variant, between, stacked
from shapegoogle_core.evaluation.spectra_cache import (
    Arrays,
    BenchmarkCache,
    cached_spectrum,
    code_digest,
    digest,
    preparation_of,
)
from shapegoogle_core.evaluation.workshop import Source, Task, Workshop
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["BaselineGroup", "d2_group", "shape_dna_group"]


@dataclass(frozen=True)
class _ShapeDnaTask:
    preparation: Preparation
    kind: str = "baselines"

    @property
    def title(self) -> str:
        return f"Shape-DNA, {self.preparation.name}"

    @property
    def key(self) -> str:
        return digest("Shape-DNA", preparation_of(self.preparation.settings), code_digest(_CODE))

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        spectrum = cached_spectrum(cache, self.preparation.settings, source.key, source.mesh)
        return {"description": shape_dna(spectrum)}


@dataclass(frozen=True)
class _D2Task:
    seed: int
    kind: str = "baselines"
    title: str = "D2 distribution"

    @property
    def key(self) -> str:
        return digest("D2", self.seed, code_digest(_CODE))

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        del cache  # two points do not need a spectrum
        return {"description": d2_distribution(source.mesh(), seed=self.seed)}


_CODE = ("evaluation/baselines.py",)


@dataclass(frozen=True, eq=False)
class BaselineGroup:
    """One description of a whole shape, compared by one metric of `scipy.spatial.distance.cdist`."""

    task: Task
    metric: str
    variants: tuple[Variant, ...]

    def only(self, names: set[str]) -> Self:
        """Leave the variants with other names out."""
        chosen = tuple(variant for variant in self.variants if variant.name in names)
        return type(self)(self.task, self.metric, chosen)

    def match(
        self, workshop: Workshop, queries: Sequence[BenchmarkShape], database: Sequence[BenchmarkShape]
    ) -> Iterator[Matched]:
        """Compare all queries with the database."""
        known = stacked(workshop.describe(self.task, database), "description")
        asked = stacked(workshop.describe(self.task, queries), "description")
        for variant in self.variants:
            yield between(variant, self._distances, asked, known, 4 * known.shape[1])

    def _distances(self, first: FloatBags, second: FloatBags) -> FloatArray:
        metric = self.metric
        if metric == "euclidean":
            return np.asarray(cdist(first, second, "euclidean"), np.float64)
        return np.asarray(cdist(first, second, "cityblock"), np.float64)


def shape_dna_group(preparation: Preparation) -> BaselineGroup:
    """Shape-DNA of spectra of one preparation, compared by the Euclidean distance."""
    parameters: dict[str, str | int | float] = {
        "descriptor": "Shape-DNA",
        "preparation": preparation.name,
    }
    name = "Shape-DNA" if preparation.name == "paper" else f"Shape-DNA · {preparation.name}"
    variant = Variant(name, "baseline", parameters, headline=preparation.name == "paper")
    return BaselineGroup(_ShapeDnaTask(preparation), "euclidean", (variant,))


def d2_group(seed: int) -> BaselineGroup:
    """D2 distributions of the meshes as they are, compared by the L1 distance."""
    variant = Variant("D2 distribution", "baseline", {"descriptor": "D2"}, headline=True)
    return BaselineGroup(_D2Task(seed), "cityblock", (variant,))
