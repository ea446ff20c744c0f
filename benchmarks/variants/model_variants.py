# SPDX-License-Identifier: MIT
"""Variants of a trained model: its full bags, its codes, and the complete search."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Self

import numpy as np
from scipy.spatial.distance import cdist

from benchmarks.protocol.cache import Arrays, BenchmarkCache
from benchmarks.protocol.collection import BenchmarkShape
from benchmarks.protocol.matching import Matched, Variant, between, median_seconds, stacked
from benchmarks.protocol.workshop import Source, Workshop
from benchmarks.variants.described import describe_shapes, index_shapes
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.codes.hamming import asymmetric_distances
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["ModelGroup", "model_group"]


@dataclass(frozen=True)
class _SearchTask:
    """Queries a library with a shape, as a user does."""

    library_file: Path
    shapes: int
    key: str
    title: str
    kind: str = "answers"

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        del cache
        mesh, library = source.mesh(), _library(self.library_file)
        started = time.process_time()
        signature = library.model.describe(mesh)
        described = time.process_time() - started
        started = time.perf_counter()
        matches = library.query(signature, top=_TOP, explain=0)
        seconds = time.perf_counter() - started
        # The first ten are those of a query for ten; the others those of a query for all.
        seen = {match.shape_id for match in matches}
        everything = library.query(signature, top=self.shapes, explain=0)
        matches += [match for match in everything if match.shape_id not in seen]
        return {
            "sources": np.array([match.source for match in matches], dtype=np.str_),
            "distances": np.array([match.distance for match in matches], dtype=np.float64),
            "seconds": np.array(described),
            "query_seconds": np.array(seconds),
        }


# Default of `shapegoogle query`.
_TOP = 10


# Worker processes use the same library for every shape.
@lru_cache(maxsize=1)
def _library(path: Path) -> Library:
    return Library.open(path, read_only=True)


@dataclass(frozen=True, eq=False)
class ModelGroup:
    """Variants of one model, see `model_group`."""

    model: ShapeModel
    variants: tuple[Variant, ...]

    def only(self, names: set[str]) -> Self:
        """Return the group without the variants of other names."""
        return replace(self, variants=tuple(v for v in self.variants if v.name in names))

    def match(
        self, workshop: Workshop, queries: Sequence[BenchmarkShape], database: Sequence[BenchmarkShape]
    ) -> Iterator[Matched]:
        """Compare all queries with the database, for each of the variants."""
        stages = {variant.parameters["stage"]: variant for variant in self.variants}
        if stages.keys() - {"search"}:
            yield from self._match_signatures(workshop, queries, database, stages)
        if "search" in stages:
            yield self._search(workshop, queries, database, stages["search"])

    def _match_signatures(
        self,
        workshop: Workshop,
        queries: Sequence[BenchmarkShape],
        database: Sequence[BenchmarkShape],
        stages: dict[str | int | float, Variant],
    ) -> Iterator[Matched]:
        model = self.model
        known, asked = (describe_shapes(workshop, model, shapes) for shapes in (database, queries))
        cost = median_seconds([*known, *asked])
        if "full bags" in stages:
            first, second = (
                _where_finite(model.comparable, stacked(described, "bags")) for described in (asked, known)
            )

            def compare(queries: FloatBags, others: FloatBags) -> FloatArray:
                metric = model.settings.metric
                return np.array([row_distances(metric, query[None], others) for query in queries])

            # Bags are stored as half floats.
            yield between(stages["full bags"], compare, first, second, 2 * model.bag_size, cost)
        if "codes" in stages:
            first, second = stacked(asked, "code"), stacked(known, "code")
            yield between(stages["codes"], hamming, first, second, model.code_bits // 8, cost)
        if "asymmetric codes" in stages:
            first = _where_finite(model.code_projections, stacked(asked, "bags"))
            second = stacked(known, "code")

            def weigh(projections: FloatBags, codes: FloatBags) -> FloatArray:
                packed = codes.astype(np.uint8)
                return np.array([asymmetric_distances(packed, one) for one in projections], np.float64)

            yield between(stages["asymmetric codes"], weigh, first, second, model.code_bits // 8, cost)

    def _search(
        self,
        workshop: Workshop,
        queries: Sequence[BenchmarkShape],
        database: Sequence[BenchmarkShape],
        variant: Variant,
    ) -> Matched:
        indexed = index_shapes(workshop, self.model, database)
        task = _SearchTask(indexed.library_file, len(database), indexed.key, f"{self.model.name}: search")
        answers = workshop.describe(task, queries)
        column = {source: index for index, source in enumerate(indexed.sources)}
        distances = np.full((len(queries), len(database)), np.inf)
        times = []
        for row, answer in zip(distances, answers, strict=True):
            if answer is not None:
                places = [column[source] for source in answer["sources"]]
                row[places] = _in_order(answer["distances"])
                times.append(answer["query_seconds"])
        seconds = float(np.median(times)) if times else float("nan")
        return Matched(variant, distances, seconds, indexed.bytes_per_shape, median_seconds(answers))


def model_group(model: ShapeModel, name: str = "") -> ModelGroup:
    """Make the variants of a model.

    Parameters
    ----------
    model : ShapeModel
    name : str, optional
        Name in the table; default: the model's name.

    Returns
    -------
    group : ModelGroup
        Four variants: "full bags" compares the bags of all shapes, "codes" their codes alone, "asymmetric
        codes" the same codes with the query's projections, and "search" queries a `Library` in a file for
        ten matches, as a user does.
    """
    name = name or model.name
    bits = model.code_bits
    described: dict[str, str | int | float] = {"model": name, "bits": bits}
    return ModelGroup(
        model,
        (
            Variant(f"{name} · full bags", "model", {"model": name, "stage": "full bags"}, headline=True),
            Variant(f"{name} · {bits}-bit codes", "codes", {**described, "stage": "codes"}, headline=True),
            Variant(
                f"{name} · {bits}-bit codes, asymmetric",
                "codes",
                {**described, "stage": "asymmetric codes"},
                headline=True,
            ),
            Variant(f"{name} · search", "model", {**described, "stage": "search"}, headline=True),
        ),
    )


def hamming(first: FloatBags, second: FloatBags) -> FloatArray:
    """Compute Hamming distances between packed codes.

    Parameters
    ----------
    first, second : (q, bytes) and (d, bytes) arrays
        Whole numbers from 0 to 255.

    Returns
    -------
    distances : (q, d) array
        Numbers of differing bits.
    """
    a, b = (np.unpackbits(codes.astype(np.uint8), axis=1) for codes in (first, second))
    return np.asarray(cdist(a, b, "cityblock"), np.float64)


def _where_finite(function: Callable[[FloatBags], FloatBags], rows: FloatBags) -> FloatBags:
    """Apply a function of rows to the rows without NaN."""
    usable = np.isfinite(rows).all(axis=1)
    if not usable.any():
        return rows
    values = function(rows[usable])
    result = np.full((len(rows), values.shape[1]), np.nan, np.float32)
    result[usable] = values
    return result


def _in_order(distances: FloatArray) -> FloatArray:
    """Change the distances of matches, best first, as little as possible so that they increase.

    The order is that of the search, which sorts equal distances by name.
    """
    steps = np.arange(len(distances)) * 1e-9
    return np.asarray(np.maximum.accumulate(distances) + steps)
