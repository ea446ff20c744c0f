# SPDX-License-Identifier: MIT
"""Measure the search by the size of the library: codes in memory, library files, recall of the codes.

codes    synthetic codes of 128 and 256 bits: the ten nearest, and the number that the search compares by bags
library  synthetic library files, each opened by a new process: first and next query, adding and removing a
         shape, bytes for each shape. Up to `FULL_LIBRARY` shapes have bags and samples of the shipped model's
         size; larger libraries have codes of that size, but small bags and no samples, to fit on a disk.
recall   share of the ten nearest shapes by bags among the candidates by codes, for synthetic bags with the
         variances of real ones, and with --library for the shapes of a real library
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import shapegoogle_core as sg
from benchmarks.experiments.duplicates import DECAY
from benchmarks.speed.measuring import Options, Row
from benchmarks.speed.processes import figures_of
from benchmarks.speed.reporting import label, panels
from shapegoogle_core.library.search.codes.code_index import CodeIndex
from shapegoogle_core.library.search.codes.hamming import (
    BitCounter,
    asymmetric_distances,
    count_bits,
    count_bits_portable,
)
from shapegoogle_core.library.search.settings import CandidateSettings
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.model import ChannelSettings, ModelSettings
from shapegoogle_core.model.shape_bags import ChannelWords

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["REPEATS", "SIZES", "draw", "measure"]

SIZES, REPEATS = (10**3, 10**4, 10**5, 10**6, 10**7), 9
Codes = NDArray[np.uint8]

BITS = (128, 256)
CANDIDATES, OVERSAMPLING = CandidateSettings.count, CandidateSettings.oversampling
TOPS = (10, CANDIDATES)
FULL_LIBRARY, LARGEST_LIBRARY = 100_000, 1_000_000
RECALL_SIZES = (1_000, 10_000, 100_000)
CANDIDATE_COUNTS = (10, 30, 100, CANDIDATES, 1_000)
QUERIES = 50
AT_ONCE = 5_000
GOALS = {128: {1_000_000: 5, 10_000_000: 100}}  # milliseconds


def measure(options: Options) -> Iterator[Row]:
    """Measure all three parts.

    Parameters
    ----------
    options : Options
        Sizes are numbers of shapes; library files have at most `LARGEST_LIBRARY`, recall at most the last of
        `RECALL_SIZES`. The folder needs 22 kB for each of `FULL_LIBRARY` shapes.

    Yields
    ------
    row : dict
        With "part". Times in milliseconds; "cpu" is processor time, "wall" is wall time.
    """
    for size in options.sizes:
        yield from measure_codes(size, options.repeats)
    for size in options.sizes:
        if size <= LARGEST_LIBRARY:
            yield measure_library(size, options.repeats, options.folder)
    for size in RECALL_SIZES:
        if size <= max(options.sizes):
            yield from measure_recall("synthetic", made_up_vectors(size))
    if options.library is not None:
        yield from measure_recall("real", real_vectors(options.library))


# -- codes in memory ----------------------------------------------------------------------------------------


def counters() -> dict[str, BitCounter]:
    """List the bit counters by name; before numpy 2.0 "numpy" is the portable one."""
    found = {"numpy": count_bits}
    if count_bits is not count_bits_portable:
        found["numpy < 2"] = count_bits_portable
    return found


def measure_codes(size: int, repeats: int) -> Iterator[Row]:
    """Search synthetic codes; the bit counters take turns, so that other load affects them equally."""
    random = np.random.default_rng(0)
    for bits in BITS:
        filled = {name: CodeIndex(counter) for name, counter in counters().items()}
        for start in range(0, size, 1_000_000):
            codes = random.integers(0, 256, (min(1_000_000, size - start), bits // 8), np.uint8)
            for index in filled.values():
                index.add(start + np.arange(len(codes)), codes)
        times: dict[tuple[str, int], list[float]] = {}
        for query in random.integers(0, 256, (repeats, bits // 8), np.uint8):
            for top in TOPS:
                answers = []
                for name, index in filled.items():
                    started = time.process_time()
                    answers.append(index.nearest(query, top).tolist())
                    times.setdefault((name, top), []).append(1e3 * (time.process_time() - started))
                if any(answer != answers[0] for answer in answers):
                    raise AssertionError(
                        f"the ways to count bits do not agree on {size} codes of {bits} bits"
                    )
        for (name, top), values in times.items():
            cpu = round(statistics.median(values), 3)
            yield {"part": "codes", "size": size, "bits": bits, "table": name, "top": top, "cpu": cpu}


# -- library files ------------------------------------------------------------------------------------------


def small_model() -> sg.ShapeModel:
    """Make a random model with codes as long as those of the shipped one, but bags of six words."""
    random = np.random.default_rng(0)
    channel = ChannelSettings("hks", {"times": [0.01, 0.03, 0.1], "normalize": True}, words=6)
    settings = ModelSettings(
        name="small",
        channels=(channel,),
        preprocessing=None,
        laplacian="cotangent",
        projected=16,
        code_bits=256,
    )
    return sg.ShapeModel(
        settings=settings,
        vocabularies=(ChannelWords(random.uniform(0.2, 1.0, (6, 3)), sigma=0.3),),
        weights=np.ones(settings.bag_size, np.float32),
        mean=np.zeros(settings.bag_size, np.float32),
        projection=random.standard_normal((settings.bag_size, 16)).astype(np.float16),
        directions=random.standard_normal((256, 16)).astype(np.float32),
        thresholds=np.zeros(256, np.float32),
        similarity_half=0.1,
        similarity_slope=2.0,
        trained_on="nothing: random numbers to measure time",
    )


def made_up_signature(model: sg.ShapeModel, like: sg.ShapeSignature | None, seed: int) -> sg.ShapeSignature:
    """Make a random signature, with the sample of another signature for its size."""
    random = np.random.default_rng(seed)
    return sg.ShapeSignature(
        bags=random.random(model.bag_size, np.float32),
        code=random.integers(0, 256, model.code_bits // 8, np.uint8),
        area=1.0,
        vertex_count=100,
        face_count=200,
        sample=None if like is None else like.sample,
    )


def fill(path: Path, size: int, model: sg.ShapeModel, like: sg.ShapeSignature | None) -> None:
    """Make a library of synthetic shapes, with `AT_ONCE` shapes in each source."""
    with sg.Library.open(path, model) as library:
        for start in range(0, size, AT_ONCE):
            shapes = [
                NewShape(made_up_signature(model, like, seed), f"shape {seed}")
                for seed in range(start, min(start + AT_ONCE, size))
            ]
            library.replace_source(f"made-up/{start}", size=0, mtime_ns=0, sha256=None, shapes=shapes)


def measure_library(size: int, repeats: int, folder: Path) -> Row:
    """Make a library file; a new process opens, queries and changes it."""
    full = size <= FULL_LIBRARY
    model, like = small_model(), None
    if full:
        from benchmarks.creatures import CREATURE_KINDS, make_creature

        model = sg.load_model()
        like = model.describe(make_creature(CREATURE_KINDS[0], 100, 3_000).pose(100))
    with tempfile.TemporaryDirectory(dir=folder) as place:
        path = Path(place) / "made-up.sglib"
        fill(path, size, model, like)
        row: Row = {"part": "library", "size": size, "bag": model.bag_size, "sample": full}
        row["bytes_per_shape"] = round(path.stat().st_size / size, 1)
        # After the library is complete, so that nothing else of this program runs.
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
            row |= process.submit(use_library, path, like, repeats).result()
        row["sync_wall"] = sync_time(Path(place), repeats)
    return row


def use_library(path: Path, like: sg.ShapeSignature | None, repeats: int) -> Row:
    """Time the use of a library file, and measure its memory in megabytes; runs in a new process."""
    row: Row = {}
    before = figures_of()

    def timed(name: str, action: Callable[..., object], *arguments: object) -> None:
        wall, cpu = time.perf_counter(), time.process_time()
        action(*arguments)
        row.setdefault(name + "_cpu", []).append(1e3 * (time.process_time() - cpu))
        row.setdefault(name + "_wall", []).append(1e3 * (time.perf_counter() - wall))

    def open_and_ask() -> None:
        with sg.Library.open(path, read_only=True) as library:
            library.query(query, explain=0)

    with sg.Library.open(path, read_only=True) as library:
        model = library.model
    query = made_up_signature(model, like, 10**9)
    for _ in range(repeats):
        if forget_file(path):
            timed("first_cold", open_and_ask)
        timed("first", open_and_ask)
    with sg.Library.open(path) as library, sg.Library.open(path) as other:
        library.query(query, explain=0)
        after = figures_of()
        if before is not None and after is not None:
            row["memory_mb"] = round(after.peak_mb - before.peak_mb)
        for seed in range(repeats):
            query = made_up_signature(model, like, 2 * 10**9 + seed)
            timed("next", search, library, query)
            new = made_up_signature(model, like, 3 * 10**9 + seed)
            # A writer pauses after each change so that others can read; a single change does not wait.
            time.sleep(0.2)
            timed("add", other.add_signature, new, "new", "new.obj")
            timed("after_add", search, library, query)
            time.sleep(0.2)
            timed("remove", other.remove, "new.obj")
            timed("after_remove", search, library, query)
    return {
        name: round(statistics.median(value), 2) if isinstance(value, list) else value
        for name, value in row.items()
    }


def search(library: sg.Library, query: sg.ShapeSignature) -> None:
    """Search without evidence."""
    library.query(query, explain=0)


def forget_file(path: Path) -> bool:
    """Drop a file from the system's cache; return False where that is not possible."""
    if not hasattr(os, "posix_fadvise"):
        return False
    with path.open("rb") as file:
        os.fsync(file.fileno())
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
    return True


def sync_time(folder: Path, repeats: int) -> float:
    """Time a sync of one page to this disk, in milliseconds; a change of a library needs about six."""
    times = []
    with tempfile.TemporaryFile(dir=folder) as file:
        for _ in range(max(repeats, 5)):
            file.seek(0)
            file.write(bytes(4096))
            file.flush()
            started = time.perf_counter()
            os.fsync(file.fileno())
            times.append(1e3 * (time.perf_counter() - started))
    return round(statistics.median(times), 2)


# -- recall -------------------------------------------------------------------------------------------------

# A model, the vectors it compares, and their projections, whose signs are the codes.
Vectors = tuple[sg.ShapeModel, NDArray[np.float32], NDArray[np.float32]]


def made_up_vectors(size: int) -> Vectors:
    """Make random vectors of shapes in families of ten, as the shipped model compares them.

    Without families all distances would be nearly equal, and codes could not separate the nearest.
    """
    model = sg.load_model()
    random = np.random.default_rng(0)
    dimensions = model.projection.shape[1]
    spread = 1 / (1 + np.arange(dimensions) / DECAY)
    families = random.standard_normal((-(-size // 10), dimensions)) * spread
    vectors = np.repeat(families, 10, axis=0)[:size]
    vectors += 0.6 * random.standard_normal(vectors.shape) * spread
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    compared = vectors.astype(np.float32)
    # As in `ShapeModel.code_projections`.
    return model, compared, np.asarray(compared @ model.directions.T + model.thresholds, np.float32)


def real_vectors(path: Path) -> Vectors:
    """Read the vectors that its model compares from a library."""
    with sg.Library.open(path, read_only=True) as library:
        bags = np.stack([library.signature(record.shape_id).bags for record in library.shapes()])
        model = library.model
        return model, model.comparable(bags), np.asarray(model.code_projections(bags), np.float32)


def measure_recall(kind: str, shapes: Vectors) -> Iterator[Row]:
    """Compute the share of the ten nearest others of some shapes that are candidates by their codes.

    "asymmetric" candidates are chosen as in the search: by asymmetric distance among `OVERSAMPLING` times as
    many nearest codes.
    """
    model, vectors, projections = shapes
    codes = np.packbits(projections > 0, axis=1)
    index = CodeIndex()
    index.add(np.arange(len(codes)), codes)
    queries = np.random.default_rng(1).choice(len(vectors), min(QUERIES, len(vectors)), replace=False)
    counts = [count for count in CANDIDATE_COUNTS if count < len(vectors)]
    found: dict[tuple[str, int], list[float]] = {}
    for query in queries.tolist():
        if model.settings.metric == "cosine":
            distances = 1 - vectors @ vectors[query]
        else:
            distances = np.abs(vectors - vectors[query]).sum(axis=1)
        distances[query] = np.inf
        nearest = np.argpartition(distances, 10)[:10]
        by_code = index.nearest(codes[query], OVERSAMPLING * max(counts) + 1)
        by_code = by_code[by_code != query]
        for count in counts:
            rough = by_code[: OVERSAMPLING * count]
            nearer = np.argsort(asymmetric_distances(codes[rough], projections[query]), kind="stable")
            for distance, candidates in (("Hamming", by_code), ("asymmetric", rough[nearer])):
                share = float(np.isin(nearest, candidates[:count]).mean())
                found.setdefault((distance, count), []).append(share)
    for (distance, count), shares in found.items():
        yield {
            "part": "recall",
            "kind": kind,
            "distance": distance,
            "size": len(vectors),
            "bits": 8 * codes.shape[1],
            "candidates": count,
            "recall": round(statistics.mean(shares), 4),
        }


# -- the figure ---------------------------------------------------------------------------------------------


def draw(rows: Sequence[Row]) -> Figure:
    """Plot times and recall against size.

    Parameters
    ----------
    rows : sequence of dict
        From `measure`.

    Returns
    -------
    figure : matplotlib.figure.Figure
    """
    figure, (codes, library, recall) = panels(3, 15, 4.5)
    colors = {"numpy": "C0", "numpy < 2": "C1"}
    for bits, style in zip(BITS, ("-", "--"), strict=True):
        for table, color in colors.items():
            points = [
                (row["size"], row["cpu"])
                for row in rows
                if row["part"] == "codes" and (row["bits"], row["table"], row["top"]) == (bits, table, 10)
            ]
            if points:
                name = f"{table}, {bits} bits"
                codes.loglog(*zip(*points, strict=True), style, color=color, marker=".", label=name)
    for bits, goals in GOALS.items():
        for size, most in goals.items():
            codes.plot(size, most, "v", color=colors["numpy"], label=f"at most, numpy, {bits}")
    codes.set(title="the ten nearest codes", xlabel="codes", ylabel="ms of processor time")
    libraries = [row for row in rows if row["part"] == "library"]
    for key, name in (
        ("first_cold_wall", "open and first answer, cold disk"),
        ("first_wall", "open and first answer"),
        ("next_wall", "next answer"),
        ("after_add_wall", "answer after a shape was added"),
        ("add_wall", "adding one shape"),
    ):
        points = [(row["size"], row[key]) for row in libraries if key in row]
        if points:
            library.loglog(*zip(*points, strict=True), marker=".", label=name)
    library.set(
        title=f"library file (beyond {FULL_LIBRARY:,} shapes: small bags)", xlabel="shapes", ylabel="ms"
    )
    recalled = [row for row in rows if row["part"] == "recall" and row["distance"] == "asymmetric"]
    for kind, size in sorted({(row["kind"], row["size"]) for row in recalled}):
        points = [
            (row["candidates"], row["recall"])
            for row in recalled
            if (row["kind"], row["size"]) == (kind, size)
        ]
        style = "-" if kind == "real" else ":"
        recall.semilogx(*zip(*points, strict=True), style, marker=".", label=f"{size:,} {kind} shapes")
    recall.axvline(CANDIDATES, color="0.7")
    recall.set(title="ten nearest by bags among the candidates", xlabel="candidates by codes", ylabel="share")
    for axes in (codes, library, recall):
        label(axes)
    return figure
