# SPDX-License-Identifier: MIT
"""What many made-up shapes cost in a database, and how well its index finds the nearest codes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing

import numpy as np
from numpy.typing import NDArray

import shapegoogle_core as sg
from benchmarks.speed.search import small_model
from benchmarks.studio.command import StudioOptions
from benchmarks.studio.made_up import Row, made_up_shapes, median, processor_seconds, timed
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.settings import CandidateSettings
from shapegoogle_core.library.storage.opening import connect
from shapegoogle_core.library.storage.postgresql.administration import index_statements, run_statements
from shapegoogle_core.library.storage.postgresql.codes import CODE_INDEX
from shapegoogle_core.library.storage.postgresql.store import PostgresqlStore

__all__ = ["measure"]

WHOLE = 20_000
"""Shapes that are stored with all their rows, for the bytes of one."""

CODE_BYTES = 32
QUERIES = 20
FOUND = CandidateSettings.count * CandidateSettings.oversampling
# Shapes of one kind have near codes; a tenth of all are copies.
PER_KIND, WITHIN, DIMENSIONS = 50, 0.3, 16


def measure(options: StudioOptions) -> Iterator[Row]:
    """Measure whole shapes first, then records and codes of the sizes that were asked for."""
    yield _whole(options)
    for size in options.sizes:
        yield _codes(options, size)


def _whole(options: StudioOptions) -> Row:
    """Store whole shapes of the shipped model's size."""
    model, place = sg.load_model(), options.server.new_url()
    seconds = 0.0
    with Library.open(place, model) as library, library.neighbours_later():
        for start in range(0, WHOLE, 500):
            shapes = made_up_shapes(model, range(start, start + 500))
            started = time.perf_counter()
            library.replace_source(f"made-up/{start}", size=0, mtime_ns=0, sha256=None, shapes=shapes)
            seconds += time.perf_counter() - started
    with closing(_open(place)) as store:
        return {
            "rows": "all",
            "shapes": WHOLE,
            "bytes_each": round(store.summary().bytes / WHOLE),
            **{f"bytes_each_{table}": round(size / WHOLE) for table, size in _sizes(store).items()},
            "store_seconds": round(seconds, 1),
        }


def _codes(options: StudioOptions, size: int) -> Row:
    """Store records and codes only; search exactly, make the index, and search with it."""
    place = options.server.new_url()
    Library.open(place, small_model()).close()
    random = np.random.default_rng(0)
    codes, asked = _made_up_codes(random, size)
    row: Row = {"rows": "records and codes", "shapes": size, "found": FOUND}
    with closing(_open(place)) as store:
        # One process, whose time counts.
        store.rows("SELECT set_config('max_parallel_workers_per_gather', '0', FALSE)")
        store.rows("SELECT set_config('max_parallel_maintenance_workers', '0', FALSE)")
        server = store.connection.info.backend_pid
        started = time.perf_counter()
        _copy(store, codes)
        store.execute("ANALYZE codes")
        row |= {"store_seconds": timed(started), "bytes_each": round(store.summary().bytes / size)}
        row["bytes_each_codes"] = round(_sizes(store)["codes"] / size)
        store.compared_in_memory = 0
        exact = [_search(store, server, code) for code in asked]
        row |= {"exact_ms": median([wall for _, wall, _ in exact])}
        row["exact_cpu_ms"] = median([spent for _, _, spent in exact])
        started, before = time.perf_counter(), processor_seconds(server)
        run_statements(store, index_statements(store))
        row |= {"index_seconds": timed(started)}
        row["index_cpu_seconds"] = round(processor_seconds(server) - before, 1)
        row["index_bytes_each"] = round(
            store.value("SELECT pg_relation_size(to_regclass(%s))", CODE_INDEX) / size
        )
        row["lists"] = store.index_lists()
        found = [_search(store, server, code) for code in asked]
        row |= {"index_ms": median([wall for _, wall, _ in found])}
        row["index_cpu_ms"] = median([spent for _, _, spent in found])
        recalls = [
            _recall(code, codes, truth, near)
            for code, (truth, _, _), (near, _, _) in zip(asked, exact, found, strict=True)
        ]
        row |= {"recall": round(float(np.mean(recalls)), 4), "least_recall": round(min(recalls), 4)}
    return row


def _open(place: str) -> PostgresqlStore:
    store = connect(place, read_only=False, timeout=600)
    assert isinstance(store, PostgresqlStore)
    return store


def _made_up_codes(random: np.random.Generator, size: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Make codes of shapes, of which some are copies of others, and codes to search for.

    As those of a model they are the sides of planes on which projected bags lie, whose variances decrease.
    """
    spread = (1 / np.sqrt(1 + np.arange(DIMENSIONS))).astype(np.float32)
    planes = random.standard_normal((DIMENSIONS, 8 * CODE_BYTES), np.float32)
    kinds = spread * random.standard_normal((max(1, size // PER_KIND), DIMENSIONS), np.float32)

    def some(count: int) -> NDArray[np.uint8]:
        own = kinds[random.integers(0, len(kinds), count)]
        varied = own + WITHIN * spread * random.standard_normal(own.shape, np.float32)
        return np.packbits(varied @ planes > 0, axis=1)

    codes = np.concatenate([some(min(100_000, size - start)) for start in range(0, size, 100_000)])
    copies = random.choice(size, size // 10, replace=False)
    codes[copies] = codes[random.integers(0, size, len(copies))]
    return codes, some(QUERIES)


def _copy(store: PostgresqlStore, codes: NDArray[np.uint8]) -> None:
    """Store records and codes in one transaction."""
    columns = "id, object_name, name, vertex_count, face_count, area, extent_x, extent_y, extent_z"
    with store.writing(), store.connection.cursor() as cursor:
        with cursor.copy(f"COPY shapes ({columns}, placement_count) FROM STDIN".encode()) as copy:
            for number in range(1, len(codes) + 1):
                copy.write_row((number, "", f"shape {number}.obj", 1000, 2000, 1.0, 1.0, 1.0, 1.0, 1))
        with cursor.copy(b"COPY codes (shape_id, code) FROM STDIN") as copy:
            for start in range(0, len(codes), 10_000):
                bits = np.unpackbits(codes[start : start + 10_000], axis=1) + ord("0")
                lines = [f"{start + place + 1}\t{row.tobytes().decode()}\n" for place, row in enumerate(bits)]
                copy.write("".join(lines))


def _search(
    store: PostgresqlStore, server: int, code: NDArray[np.uint8]
) -> tuple[NDArray[np.int64], float, float]:
    """Find the nearest codes; return their ids, the milliseconds it took and those that the server spent."""
    started, before = time.perf_counter(), processor_seconds(server)
    found = store.nearest_codes(code, FOUND)
    assert found is not None
    spent = processor_seconds(server) - before
    return found, 1e3 * (time.perf_counter() - started), 1e3 * spent


def _recall(
    code: NDArray[np.uint8], codes: NDArray[np.uint8], truth: NDArray[np.int64], found: NDArray[np.int64]
) -> float:
    """Share of the codes that are as near as the farthest to find; which of equals are found is no matter."""
    distances, nearest = (np.unpackbits(codes[ids - 1] ^ code, axis=1).sum(axis=1) for ids in (found, truth))
    return float((distances <= nearest.max()).sum() / len(truth))


def _sizes(store: PostgresqlStore) -> dict[str, int]:
    """Return the bytes of each table that has any, with its indexes."""
    rows = store.rows(
        "SELECT relname::text, pg_total_relation_size(oid) FROM pg_class"
        " WHERE relnamespace = to_regnamespace(quote_ident(%s)) AND relkind = 'r' AND reltuples != 0",
        store.address.schema,
    )
    return {str(name): int(size) for name, size in rows if size > 2**20 or name == "codes"}
