# SPDX-License-Identifier: MIT
"""Shapes that processes store in a database at once."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import shapegoogle_core as sg
from benchmarks.studio.command import StudioOptions
from benchmarks.studio.made_up import Row, made_up_shapes
from shapegoogle_core.library.library import Library

__all__ = ["measure"]

SHAPES = 1_000
AT_ONCE = (1, 50)
WORKERS = (1, 2)


def measure(options: StudioOptions) -> Iterator[Row]:
    """Let 1 and 2 workers store the same number of shapes each; describing them is not part of it."""
    model = sg.load_model()
    for at_once in AT_ONCE:
        for workers in WORKERS:
            place = options.server.new_url()
            Library.open(place, model).close()
            with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
                # Models are loaded and signatures made before the time begins.
                list(pool.map(_prepare, range(4 * workers)))
                started = time.perf_counter()
                spent = sum(pool.map(_store, [(place, worker, at_once, SHAPES) for worker in range(workers)]))
                seconds = time.perf_counter() - started
            with Library.open(place, read_only=True) as library:
                stored, size = len(library), library.info()["bytes"]
            assert isinstance(size, int)
            yield {
                "workers": workers,
                "shapes_per_transaction": at_once,
                "shapes": stored,
                "per_second": round(stored / seconds),
                "cpu_ms_each": round(1e3 * spent / stored, 2),
                "bytes_each": round(size / stored),
            }


def _prepare(_number: int) -> None:
    made_up_shapes(sg.load_model(), range(2))


def _store(task: tuple[str, int, int, int]) -> float:
    """Store a worker's shapes; return its processor time."""
    place, worker, at_once, count = task
    shapes = made_up_shapes(sg.load_model(), range(worker * count, (worker + 1) * count))
    before = time.process_time()
    with Library.open(place) as library, library.neighbours_later():
        for start in range(0, count, at_once):
            portion = shapes[start : start + at_once]
            name = f"{worker}/{start}"
            library.replace_source(name, size=0, mtime_ns=0, sha256="", shapes=portion, claim=True)
    return time.process_time() - before
