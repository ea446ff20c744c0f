# SPDX-License-Identifier: MIT
"""The same queries to a file, a database and its service."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

import shapegoogle_core as sg
from benchmarks.protocol import evaluation_data
from benchmarks.protocol.cache import SIGNATURE_CODE, Arrays, BenchmarkCache, code_digest, digest
from benchmarks.protocol.collection import BenchmarkShape
from benchmarks.protocol.workshop import Source, Workshop
from benchmarks.studio.command import StudioOptions
from benchmarks.studio.made_up import Row, Service, running_service
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.signature_file import signature_from_bytes, signature_to_bytes
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["measure"]

TOP = 10
_SEED = 0
# Of similarity and likeness in the answers of the service.
_DECIMALS = 6
# What a match has to be the same in.
_FIGURES = ("name", "distance", "similarity", "likeness")


@dataclass(frozen=True)
class _Described:
    """Signatures by the shipped model, as files of signatures hold them."""

    identifier: str
    title: str = "Describing shapes"
    kind: str = "signature files"

    @property
    def key(self) -> str:
        return digest(self.identifier, code_digest((*SIGNATURE_CODE, "shapegoogle_core/views")))

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        del cache  # each of these is described once
        signature = sg.load_model().describe(source.mesh())
        return {"content": np.frombuffer(signature_to_bytes(signature), np.uint8)}


def measure(options: StudioOptions) -> Iterator[Row]:
    """Ask each query of each way to search, and count the queries with different answers."""
    collection = evaluation_data.retrieval_collection(evaluation_data.read_labels(options.data), _SEED)
    model = sg.load_model()
    shapes = _chosen(collection.database, options.shapes)
    queries = _chosen(collection.queries, options.queries)
    with Workshop(BenchmarkCache(options.cache), options.jobs) as workshop:
        described = workshop.describe(_Described(model.identifier), [*shapes, *queries])
    known = [
        None if arrays is None else signature_from_bytes(arrays["content"].tobytes(), model)
        for arrays in described
    ]
    file, database = str(options.folder / "answers.sglib"), options.server.new_url()
    for place in (file, database):
        with Library.open(place, model) as library:
            for shape, signature in zip(shapes, known, strict=False):
                if signature is not None:
                    library.add_signature(signature, shape.name, source=shape.name)
    asked = [
        (query.name, signature)
        for query, signature in zip(queries, known[len(shapes) :], strict=True)
        if signature is not None
    ]
    with running_service(database) as service, Library.open(file) as one, Library.open(database) as two:
        different = {"database": 0, "service": 0}
        for _, signature in asked:
            expected = _answer(one, signature)
            different["database"] += _answer(two, signature) != expected
            different["service"] += _answer_of(service, signature) != expected
        yield {
            "shapes": len(one),
            "queries": len(asked),
            "not described": known.count(None),
            "top": TOP,
            "different": sum(different.values()),
            **{f"different from the {name}": count for name, count in different.items()},
        }


def _chosen(shapes: Sequence[BenchmarkShape], count: int | None) -> list[BenchmarkShape]:
    if count is None or count >= len(shapes):
        return list(shapes)
    return [shapes[index] for index in np.linspace(0, len(shapes) - 1, count).astype(int)]


def _answer(library: Library, signature: ShapeSignature) -> list[tuple[object, ...]]:
    matches = library.query(signature, top=TOP, explain=TOP)
    return [
        (
            match.name,
            match.distance,
            round(match.similarity, _DECIMALS),
            None if match.likeness is None else round(match.likeness, _DECIMALS),
            match.evidence and match.evidence.kind,
        )
        for match in matches
    ]


def _answer_of(service: Service, signature: ShapeSignature) -> list[tuple[object, ...]]:
    content = base64.b64encode(signature_to_bytes(signature)).decode()
    return [
        (*(match[figure] for figure in _FIGURES), match["evidence"] and match["evidence"]["kind"])
        for match in service.search({"signature": content}, TOP, TOP)
    ]
