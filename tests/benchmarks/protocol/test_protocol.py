# SPDX-License-Identifier: MIT
"""The benchmark as a whole, with a search whose answers are known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.collection import BenchmarkShape, Collection, LabelledCollection
from benchmarks.protocol.matching import Matched, Variant
from benchmarks.protocol.protocol import run_benchmark
from benchmarks.protocol.results import BenchmarkResult
from benchmarks.protocol.workshop import Workshop
from tests.benchmarks.benchmark_tasks import CountVertices


@dataclass(frozen=True)
class Known:
    """Puts the relevant shape at the place that a query's strength says; a failed query is far from all."""

    task: CountVertices
    variants: tuple[Variant, ...] = (Variant("known", "bags", {"words": 3}, headline=True),)

    def only(self, names: set[str]) -> Known:
        return replace(self, variants=tuple(v for v in self.variants if v.name in names))

    def match(
        self, workshop: Workshop, queries: Sequence[BenchmarkShape], database: Sequence[BenchmarkShape]
    ) -> Iterator[Matched]:
        described = workshop.describe(self.task, queries)
        distances = np.full((len(queries), len(database)), np.inf)
        for row, query, entry in zip(distances, queries, described, strict=True):
            if entry is not None:
                row[:] = [
                    10 * (shape.relevant != query.relevant) + column for column, shape in enumerate(database)
                ]
                own = [shape.relevant for shape in database].index(query.relevant)
                row[own] = (
                    np.sort(np.delete(row, own))[min(query.strength, 3) - 1] - 0.5 if query.strength else 0
                )
        for variant in self.variants:
            yield Matched(variant, distances, 0.25, 12, 0.125)


def run(
    group: Known, collection: Collection, cache: BenchmarkCache, labelled: Sequence[LabelledCollection] = ()
) -> BenchmarkResult:
    return run_benchmark(
        collection, labelled, [group], cache, jobs=0, seed=4, progress=lambda items, *_: items
    )


def test_ranks_are_those_of_the_distances(
    collection: Collection, cache: BenchmarkCache, tmp_path: Path
) -> None:
    result = run(Known(CountVertices(tmp_path / "trace")), collection, cache)
    (variant,) = result.variants
    assert [outcome.rank for outcome in variant.outcomes] == [1, 1, 1, 2, 2, 2]
    assert variant.table["scale"][:2] == [100, 75]
    assert (variant.seconds, variant.bytes_per_shape, variant.describe_seconds) == (0.25, 12, 0.125)
    assert result.counts == {"database": 5, "nulls": 3, "negatives": 2, "queries": 6}
    assert (result.collection, result.seed, result.problems) == ("lumps", 4, ())


def test_a_query_that_fails_counts_as_last(
    collection: Collection, cache: BenchmarkCache, tmp_path: Path
) -> None:
    task = CountVertices(tmp_path / "trace", fail="null1.scale.1")
    result = run(Known(task), collection, cache)
    (variant,) = result.variants
    assert [outcome.rank for outcome in variant.outcomes] == [1, 5, 1, 2, 2, 2]
    assert [(problem.shape, problem.kind) for problem in result.problems] == [("null1.scale.1", "failed")]


def test_a_query_that_cannot_be_made_is_no_query(
    collection: Collection, cache: BenchmarkCache, tmp_path: Path
) -> None:
    path = tmp_path / "coarse.off"
    path.write_text("OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    impossible = BenchmarkShape("null0.topology.5", path, "null0", "topology", 5, 0)
    asked = replace(collection, queries=(*collection.queries, impossible))
    result = run(Known(CountVertices(tmp_path / "trace")), asked, cache)
    assert [(problem.shape, problem.kind) for problem in result.problems] == [
        ("null0.topology.5", "left out")
    ]
    assert result.counts["queries"] == 6
    assert set(result.variants[0].table) == {"scale", "average"}
    with pytest.raises(BenchmarkError, match="none of the 1 queries"):
        run(Known(CountVertices(tmp_path / "trace")), replace(asked, queries=(impossible,)), cache)


def test_labelled_collections_are_asked_by_headline_variants(
    collection: Collection, labelled: LabelledCollection, cache: BenchmarkCache, tmp_path: Path
) -> None:
    group = Known(CountVertices(tmp_path / "trace"))
    group = replace(group, variants=(*group.variants, Variant("aside", "bags")))
    result = run(group, collection, cache, [labelled])
    (category,) = result.categories
    assert (category.collection, category.variant) == ("two kinds", "known")
    assert 0 < category.scores.first_tier < 1


def test_nothing_to_measure(collection: Collection, cache: BenchmarkCache, tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match="no variant"):
        run(Known(CountVertices(tmp_path / "trace"), ()), collection, cache)
