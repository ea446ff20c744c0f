# SPDX-License-Identifier: MIT
"""Signatures of the shapes of a benchmark, and a library of them; each is made once."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchmarks.protocol.cache import (
    SEARCH_CODE,
    SIGNATURE_CODE,
    Arrays,
    BenchmarkCache,
    code_digest,
    digest,
)
from benchmarks.protocol.collection import BenchmarkShape
from benchmarks.protocol.workshop import Source, Workshop, shape_key
from shapegoogle_core.indexing import IndexSettings, index_files
from shapegoogle_core.indexing.files import absolute
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.signature_file import signature_to_bytes
from shapegoogle_core.model import ShapeModel, load_model

__all__ = ["IndexedShapes", "describe_shapes", "index_shapes"]


@dataclass(frozen=True)
class _SignatureTask:
    """Describes a shape with a model, and keeps all of its signature."""

    model_file: Path
    key: str
    title: str
    kind: str = "whole signatures"

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        del cache  # intermediate results of a signature are not kept
        mesh, model = source.mesh(), _model(self.model_file)
        started = time.process_time()
        signature = model.describe(mesh)
        seconds = time.process_time() - started
        return {
            "bags": signature.bags,
            "code": signature.code,
            "content": np.frombuffer(signature_to_bytes(signature), np.uint8),
            "seconds": np.array(seconds),
        }


# Worker processes use the same model for every shape.
@lru_cache(maxsize=2)
def _model(path: Path) -> ShapeModel:
    return load_model(path)


def describe_shapes(
    workshop: Workshop, model: ShapeModel, shapes: Sequence[BenchmarkShape]
) -> list[Arrays | None]:
    """Describe shapes with a model, unless that was done before.

    Parameters
    ----------
    workshop : Workshop
    model : ShapeModel
    shapes : sequence of BenchmarkShape

    Returns
    -------
    signatures : list of dict of str to array, or None
        "bags" and "code" of the signature, "content" as `signature_to_bytes` writes all of it, and "seconds"
        of processor time. None for a shape that failed; the workshop has the reason.
    """
    path = workshop.cache.path("models", model.identifier, ".npz")
    if not path.exists():
        unfinished = path.with_name(f".{path.name}.{os.getpid()}")
        model.save(unfinished)
        unfinished.replace(path)
    key = digest(model.identifier, code_digest((*SIGNATURE_CODE, "shapegoogle_core/views")))
    return workshop.describe(_SignatureTask(path, key, f"{model.name}: signatures"), shapes)


@dataclass(frozen=True)
class IndexedShapes:
    """A library of the shapes of a benchmark.

    Attributes
    ----------
    library_file : Path
    sources : tuple of str
        Of the shapes, in their order.
    key : str
        Digest of everything that the library depends on.
    bytes_per_shape : int
        What the library stores of a shape for matching.
    """

    library_file: Path
    sources: tuple[str, ...]
    key: str
    bytes_per_shape: int


def index_shapes(workshop: Workshop, model: ShapeModel, shapes: Sequence[BenchmarkShape]) -> IndexedShapes:
    """Index the files of shapes, unless that was done before.

    Parameters
    ----------
    workshop : Workshop
        Its failures get the files that cannot be indexed.
    model : ShapeModel
    shapes : sequence of BenchmarkShape

    Returns
    -------
    indexed : IndexedShapes
    """
    paths = [absolute(shape.path) for shape in shapes]
    contents = [shape_key(shape) for shape in shapes]
    key = digest(model.identifier, code_digest(SEARCH_CODE), [str(path) for path in paths], contents)
    library_file = workshop.cache.path("libraries", key, ".sglib")
    with Library.open(library_file, model) as library:
        size = _index(workshop, library, dict(zip(paths, shapes, strict=True)))
    return IndexedShapes(library_file, tuple(str(path) for path in paths), key, size)


def _index(workshop: Workshop, library: Library, shapes: dict[Path, BenchmarkShape]) -> int:
    """Index the shapes; return the bytes that the library stores of one for matching."""
    title = f"{library.model.name}: library"
    bar = iter(workshop.progress(range(len(shapes)), title, len(shapes)))
    report = index_files(
        library,
        list(shapes),
        IndexSettings(jobs=max(workshop.jobs, 1)),
        progress=lambda _: next(bar, None),
    )
    next(bar, None)  # closes the bar
    for path, reason in report.failed:
        workshop.failures[shapes[path].name] = reason
    size = int(str(library.info()["bytes"])) - len(library.model.to_bytes())
    size -= sum(len(library.thumbnail(shape.shape_id) or b"") for shape in library.shapes())
    return max(size, 0) // max(len(library), 1)
