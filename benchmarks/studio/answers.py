# SPDX-License-Identifier: MIT
"""The same queries to a file, a database and its service."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence

import shapegoogle_core as sg
from benchmarks.protocol import evaluation_data
from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.collection import BenchmarkShape
from benchmarks.protocol.workshop import Workshop
from benchmarks.studio.command import StudioOptions
from benchmarks.studio.made_up import Row, running_service
from benchmarks.variants.described import describe_shapes, index_shapes
from shapegoogle_core.client import ServiceLibrary
from shapegoogle_core.library.searchable import SearchableLibrary
from shapegoogle_core.library.storage.signature_file import signature_from_bytes
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["measure"]

TOP = 10
_SEED = 0
# Of similarity and likeness in the answers of the service.
_DECIMALS = 6

Answer = list[tuple[object, ...]]


def measure(options: StudioOptions) -> Iterator[Row]:
    """Ask each query of each way to search, and count the queries with different answers."""
    collection = evaluation_data.retrieval_collection(evaluation_data.read_labels(options.data), _SEED)
    model = sg.load_model()
    shapes = _chosen(collection.database, options.shapes)
    queries = _chosen(collection.queries, options.queries)
    with Workshop(BenchmarkCache(options.cache), options.jobs) as workshop:
        described = describe_shapes(workshop, model, queries)
        indexed = index_shapes(workshop, model, shapes)
    asked = [
        signature_from_bytes(arrays["content"].tobytes(), model) for arrays in described if arrays is not None
    ]
    file, database = options.folder / "answers.sglib", options.server.new_url()
    shutil.copyfile(indexed.library_file, file)
    sg.copy_library(file, database)
    with (
        running_service(database) as service,
        sg.Library.open(file, read_only=True) as one,
        sg.Library.open(database, read_only=True) as two,
        ServiceLibrary.connect(service.address, cache=options.folder) as three,
    ):
        different = {"database": 0, "service": 0}
        for signature in progress_bar(asked, "searching in three ways", len(asked)):
            expected = _answer(one, signature)
            different["database"] += _answer(two, signature) != expected
            different["service"] += _answer(three, signature) != expected
        yield {
            "shapes": len(one),
            "queries": len(asked),
            "not described": len(described) - len(asked),
            "top": TOP,
            "different": sum(different.values()),
            **{f"different from the {name}": count for name, count in different.items()},
        }


def _chosen(shapes: Sequence[BenchmarkShape], count: int | None) -> list[BenchmarkShape]:
    if count is None or count >= len(shapes):
        return list(shapes)
    return [shapes[round(step * (len(shapes) - 1) / max(1, count - 1))] for step in range(count)]


def _answer(library: SearchableLibrary, signature: ShapeSignature) -> Answer:
    """Return what the best matches have to be the same in; sources are below roots a client need not have."""
    return [
        (
            match.shape_id,
            match.name,
            match.distance,
            round(match.similarity, _DECIMALS),
            None if match.likeness is None else round(match.likeness, _DECIMALS),
            match.evidence and match.evidence.kind,
        )
        for match in library.query(signature, top=TOP, explain=TOP)
    ]
