# SPDX-License-Identifier: MIT
"""Times of answers of the service to several clients at once."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import shapegoogle_core as sg
from benchmarks.studio.command import StudioOptions
from benchmarks.studio.made_up import (
    Row,
    made_up_shapes,
    median,
    percentile,
    processor_seconds,
    running_service,
)
from shapegoogle_core.library.library import Library

__all__ = ["measure"]

SHAPES = 2_000
CLIENTS = (1, 8, 32)
REQUESTS = 64
LIMIT = 24


def measure(options: StudioOptions) -> Iterator[Row]:
    """Search by shapes of the library, without evidence: what the page asks for first."""
    model, place = sg.load_model(), options.server.new_url()
    with Library.open(place, model) as library, library.neighbours_later():
        for start in range(0, SHAPES, 200):
            shapes = made_up_shapes(model, range(start, start + 200))
            library.replace_source(f"made-up/{start}", size=0, mtime_ns=0, sha256=None, shapes=shapes)
    with running_service(place) as service:

        def ask(number: int) -> float:
            started = time.perf_counter()
            service.search({"shape_id": 1 + number * 29 % SHAPES}, LIMIT, 0)
            return 1e3 * (time.perf_counter() - started)

        ask(0)  # reads the codes
        for clients in CLIENTS:
            before, started = processor_seconds(service.process_id), time.perf_counter()
            with ThreadPoolExecutor(clients) as pool:
                times = list(pool.map(ask, range(REQUESTS)))
            spent = processor_seconds(service.process_id) - before
            yield {
                "shapes": SHAPES,
                "clients": clients,
                "requests": REQUESTS,
                "p50_ms": median(times),
                "p95_ms": percentile(times, 95),
                "per_second": round(REQUESTS / (time.perf_counter() - started), 1),
                "cpu_ms_each": round(1e3 * spent / REQUESTS, 1),
            }
