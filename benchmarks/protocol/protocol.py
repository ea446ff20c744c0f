# SPDX-License-Identifier: MIT
"""The benchmark: every variant ranks the database for every query, and is scored (paper, section 6.1)."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from datetime import datetime
from itertools import chain

import numpy as np

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.collection import Collection, LabelledCollection
from benchmarks.protocol.matching import VariantGroup
from benchmarks.protocol.metrics import category_scores
from benchmarks.protocol.results import BenchmarkResult, CategoryResult, VariantResult
from benchmarks.protocol.scoring import score_variant
from benchmarks.protocol.workshop import Progress, Workshop
from shapegoogle_core import __version__
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["run_benchmark"]


def run_benchmark(
    collection: Collection,
    labelled: Sequence[LabelledCollection],
    variants: Sequence[VariantGroup],
    cache: BenchmarkCache,
    *,
    jobs: int = 1,
    seed: int = 0,
    progress: Progress = progress_bar,
) -> BenchmarkResult:
    """Measure variants of the search.

    Results of earlier runs are taken from the cache, so an interrupted run continues. No shape ends the run:
    a query that cannot be described counts as if its null shape were last, a database shape that cannot be
    described is last, and a query that cannot be generated from its null shape is left out. All are listed in
    `BenchmarkResult.problems`.

    Parameters
    ----------
    collection : Collection
        Null shapes, unrelated shapes and queries of ranked retrieval.
    labelled : sequence of LabelledCollection
        Collections in which every shape queries for the others of its class, with headline variants only.
    variants : sequence of VariantGroup
        In the order of the table.
    cache : BenchmarkCache
    jobs : int
        Number of worker processes; 0 computes in this process. Scripts that use worker processes must call
        this function under ``if __name__ == "__main__":``.
    seed : int
        Seed of all random choices, copied into the result.
    progress : callable
        Wraps an iterable: `progress(iterable, description, total)`.

    Returns
    -------
    result : BenchmarkResult

    Raises
    ------
    BenchmarkError
        If there is no variant, no query can be generated, or the cache cannot be written.
    """
    if not any(group.variants for group in variants):
        raise BenchmarkError("no variant of the search is chosen; leave --variants out to measure all")
    results: list[VariantResult] = []
    categories: list[CategoryResult] = []
    with Workshop(cache, jobs, progress) as workshop:
        for group in variants:
            results += _ranked(collection, group, workshop)
            for labels in labelled:
                categories += _labelled(labels, group, workshop)
    order = {variant.name: place for place, variant in enumerate(chain(*(g.variants for g in variants)))}
    return BenchmarkResult(
        collection=collection.name,
        counts={**collection.counts(), "queries": len(results[0].outcomes)},
        version=__version__,
        machine={
            "system": platform.system(),
            "processor": platform.machine(),
            "cores": os.cpu_count() or 1,
            "python": platform.python_version(),
            "numpy": np.__version__,
        },
        seed=seed,
        variants=tuple(sorted(results, key=lambda result: order[result.name])),
        categories=tuple(categories),
        date=datetime.now().astimezone().isoformat(timespec="minutes"),
        problems=workshop.problems,
    )


def _ranked(collection: Collection, group: VariantGroup, workshop: Workshop) -> list[VariantResult]:
    results = []
    database = [shape.name for shape in collection.database]
    for matched in group.match(workshop, collection.queries, collection.database):
        # Known only after the attempt to generate them.
        rows = [row for row, query in enumerate(collection.queries) if query.name not in workshop.left_out]
        if not rows:
            raise BenchmarkError(
                f"none of the {len(collection.queries)} queries of {collection.name!r} can be made; take "
                "finer null shapes"
            )
        variant = matched.variant
        results.append(
            score_variant(
                variant.name,
                variant.family,
                variant.parameters,
                matched.distances[rows],
                [collection.queries[row] for row in rows],
                database,
                matched.seconds,
                matched.bytes_per_shape,
                matched.describe_seconds,
            )
        )
    return results


def _labelled(
    collection: LabelledCollection, group: VariantGroup, workshop: Workshop
) -> list[CategoryResult]:
    chosen = group.only({variant.name for variant in group.variants if variant.headline})
    if not chosen.variants:
        return []
    return [
        CategoryResult(
            collection.name, matched.variant.name, category_scores(matched.distances, collection.labels)
        )
        for matched in chosen.match(workshop, collection.shapes, collection.shapes)
    ]
