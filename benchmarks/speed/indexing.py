# SPDX-License-Identifier: MIT
"""Measure indexing: shapes per second with one worker process and with two, and memory over a long run.

jobs     for each size, this number of shapes of 10,242 vertices is indexed with ``--jobs 1`` and ``--jobs 2``
         in turn. Each pair of runs has the speed-up of two processes of plain numpy at the same time for
         comparison, because two processors may share a core and other programs may run.
memory   ten times as many shapes of 162 vertices, with two worker processes: memory of each process over time

Both need Linux for the figures of processes.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh

import shapegoogle_core as sg
from benchmarks.speed.measuring import Options, Row
from benchmarks.speed.meshes import write_mesh
from benchmarks.speed.processes import ProcessFigures, descendants
from benchmarks.speed.reporting import label, panels
from shapegoogle_core.processes.launching import single_threaded
from shapegoogle_core.processes.pool import Pool

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["REPEATS", "SIZES", "draw", "measure"]

SIZES, REPEATS = (1_000,), 1

# Of the icosahedron: 10,242 vertices, and 162.
SUBDIVISIONS, FEW_SUBDIVISIONS = 5, 2
SMALL_SHAPES_PER_SHAPE = 10
MEMORY_LIMIT = 4096
LOOK_EVERY = 1.0
POINTS = 200


def measure(options: Options) -> Iterator[Row]:
    """Measure both parts.

    Parameters
    ----------
    options : Options
        Sizes are numbers of shapes, repeats are pairs of runs. The folder needs 370 kB for each shape of
        `jobs`.

    Yields
    ------
    row : dict
        With "part". "ratio" is the speed-up in shapes per second, "ideal" that of plain numpy, and "bound"
        the limit by processor times: 2 w / (w + m) if a shape takes w seconds of the workers, and m of the
        process that stores it. Both include the start of Python, a second spread over all shapes.
    """
    threads = blas_threads()
    for size in options.sizes:
        with tempfile.TemporaryDirectory(dir=options.folder) as folder:
            write_meshes(Path(folder), size, SUBDIVISIONS)
            row = measure_jobs(Path(folder), size, options.repeats)
        yield row | {"blas_threads_of_a_worker": threads}
    size = SMALL_SHAPES_PER_SHAPE * max(options.sizes)
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        write_meshes(Path(folder), size, FEW_SUBDIVISIONS)
        yield measure_memory(Path(folder), size)


def write_meshes(folder: Path, count: int, subdivisions: int) -> None:
    """Write different lumpy spheres as binary PLY."""
    sphere = trimesh.creation.icosphere(subdivisions)
    faces = sphere.faces.astype(np.int32)
    for seed in range(count):
        random = np.random.default_rng(seed)
        centers = random.standard_normal((8, 3))
        centers /= np.linalg.norm(centers, axis=1, keepdims=True)
        lumps = np.exp(-8 * (1 - sphere.vertices @ centers.T)) @ random.uniform(-0.3, 0.6, 8)
        write_mesh(sg.Mesh(sphere.vertices * (1 + lumps)[:, None], faces), folder / f"{seed:06}.ply")


# -- one run ------------------------------------------------------------------------------------------------


@dataclass(eq=False)
class Run:
    """One run of ``shapegoogle index``.

    Attributes
    ----------
    seconds : float
        Measured by the command, without the start of Python.
    history : list of (float, dict)
        Seconds since the start, and the processes at that time; the first one stores the shapes.
    """

    seconds: float = 0.0
    history: list[tuple[float, dict[int, ProcessFigures]]] = field(default_factory=list)

    def last(self) -> dict[int, ProcessFigures]:
        """Return the last figures of each process."""
        return {process: figures for _, seen in self.history for process, figures in seen.items()}

    def main(self) -> int:
        """Return the id of the process that stores the shapes."""
        return next(iter(self.history[0][1]))

    def cpu_seconds(self) -> tuple[float, float]:
        """Return the processor time of the process that stores the shapes, and of all others."""
        last = self.last()
        of_main = last[self.main()].cpu_seconds
        return of_main, sum(figures.cpu_seconds for figures in last.values()) - of_main

    def peaks(self) -> tuple[float, float]:
        """Return the peak memory of the process that stores the shapes, and the largest of the others."""
        last, main = self.last(), self.main()
        others = [figures.peak_mb for process, figures in last.items() if process != main]
        return last[main].peak_mb, max(others, default=0.0)


def index(folder: Path, jobs: int) -> Run:
    """Index a folder into a new library and record the figures of the processes."""
    library = folder / "shapes.sglib"
    command = [sys.executable, "-m", "shapegoogle_core", "index", str(folder), "--library", str(library)]
    command += ["--json", "--jobs", str(jobs), "--memory-limit", str(MEMORY_LIMIT)]
    run = Run()
    started = time.perf_counter()
    with tempfile.TemporaryFile() as answer:
        with subprocess.Popen(command, stdout=answer, stderr=subprocess.DEVNULL) as process:
            while process.poll() is None:
                processes = descendants(process.pid)
                if processes:
                    run.history.append((time.perf_counter() - started, processes))
                time.sleep(LOOK_EVERY)
        answer.seek(0)
        record = json.loads(answer.read())
    if process.returncode or not run.history:
        raise RuntimeError(f"indexing '{folder}' failed: {record['failed'][:3]}; it also needs Linux")
    run.seconds = float(record["seconds"])
    library.unlink()
    return run


# -- one worker and two -------------------------------------------------------------------------------------


def measure_jobs(folder: Path, size: int, repeats: int) -> Row:
    """Index a folder with one worker process and with two, in turns."""
    rates: dict[int, list[float]] = {1: [], 2: []}
    ratios, ideals, bounds, main_times, worker_times = [], [], [], [], []
    main_peaks, worker_peaks, threads = [], [], []
    for _ in range(repeats):
        ideals.append(two_against_one())
        runs = {jobs: index(folder, jobs) for jobs in rates}
        for jobs, run in runs.items():
            rates[jobs].append(size / run.seconds)
            main_peak, worker_peak = run.peaks()
            main_peaks.append(main_peak)
            worker_peaks.append(worker_peak)
            workers = [figures for process, figures in run.last().items() if process != run.main()]
            threads += [figures.threads for figures in workers]
        ratios.append(rates[2][-1] / rates[1][-1])
        of_main, of_workers = runs[2].cpu_seconds()
        main_times.append(of_main / size)
        worker_times.append(of_workers / size)
        bounds.append(2 * of_workers / (of_workers + of_main))
    median = statistics.median
    return {
        "part": "jobs",
        "size": size,
        "vertices": 10 * 4**SUBDIVISIONS + 2,
        "shapes_per_second": {str(jobs): round(median(values), 3) for jobs, values in rates.items()},
        "ratio": round(median(ratios), 3),
        "ratios": [round(ratio, 3) for ratio in ratios],
        "ideal": round(median(ideals), 3),
        "bound": round(median(bounds), 3),
        "cpu_ms_of_storing": round(1e3 * median(main_times), 1),
        "cpu_ms_of_workers": round(1e3 * median(worker_times), 1),
        "peak_mb_of_storing": round(max(main_peaks)),
        "peak_mb_of_a_worker": round(max(worker_peaks)),
        "threads_of_a_worker": max(threads),
    }


def two_against_one(seconds: float = 2.0) -> float:
    """Measure the speed-up of two processes of plain numpy over one."""
    with (
        single_threaded(),
        ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool,
    ):
        list(pool.map(numpy_rounds, [0.2, 0.2]))  # waits for the start of both
        alone = pool.submit(numpy_rounds, seconds).result()
        together = sum(pool.map(numpy_rounds, [seconds, seconds]))
    return together / alone


def numpy_rounds(seconds: float) -> float:
    """Compute for some seconds; return rounds per second."""
    random = np.random.default_rng(0)
    matrix, values = random.standard_normal((300, 300)), random.standard_normal(100_000)
    order = random.permutation(len(values))
    started, rounds = time.perf_counter(), 0
    while time.perf_counter() - started < seconds:
        (matrix @ matrix).sum()
        np.sort(values[order]).cumsum()
        rounds += 1
    return rounds / (time.perf_counter() - started)


def blas_threads() -> int:
    """Return the number of threads of numerical libraries in a worker process."""
    with Pool(1, sg.IndexSettings.time_limit) as pool:
        (task,) = pool.map(threads_with, [sg.load_model().to_bytes()])
    return task.result()


def threads_with(model: bytes) -> int:
    """Load a model; return the number of threads of numerical libraries in this process."""
    from threadpoolctl import threadpool_info

    sg.ShapeModel.from_bytes(model)
    return max(int(pool["num_threads"]) for pool in threadpool_info())


# -- memory -------------------------------------------------------------------------------------------------


def measure_memory(folder: Path, size: int) -> Row:
    """Index a folder of many small shapes and record the memory of the processes over time."""
    run = index(folder, 2)
    main = run.main()
    step = max(1, len(run.history) // POINTS)
    curve = [
        {
            "seconds": round(seconds, 1),
            "storing_mb": round(seen[main].memory_mb, 1),
            "worker_mb": round(
                max((figures.memory_mb for process, figures in seen.items() if process != main), default=0), 1
            ),
        }
        for seconds, seen in run.history[::step]
        if main in seen
    ]
    main_peak, worker_peak = run.peaks()
    return {
        "part": "memory",
        "size": size,
        "vertices": 10 * 4**FEW_SUBDIVISIONS + 2,
        "shapes_per_second": round(size / run.seconds, 2),
        "peak_mb_of_storing": round(main_peak),
        "peak_mb_of_a_worker": round(worker_peak),
        # From the first half of the run to the second; 0 means constant memory.
        "growth_mb_of_storing": growth(curve, "storing_mb"),
        "growth_mb_of_a_worker": growth(curve, "worker_mb"),
        "curve": curve,
    }


def growth(curve: list[dict[str, float]], name: str) -> float:
    """Compute the increase of the maximum from the second quarter, after the start, to the last half."""
    values = [point[name] for point in curve]
    quarter, half = len(values) // 4, len(values) // 2
    return round(max(values[half:]) - max(values[quarter : half + 1]), 1)


# -- the figure ---------------------------------------------------------------------------------------------


def draw(rows: Sequence[Row]) -> Figure:
    """Plot shapes per second and memory.

    Parameters
    ----------
    rows : sequence of dict
        From `measure`.

    Returns
    -------
    figure : matplotlib.figure.Figure
    """
    figure, (rates, memory) = panels(2, 10, 4)
    for row in rows:
        if row["part"] == "jobs":
            name = f"{row['size']:,} shapes: {row['ratio']:.2f} (plain numpy {row['ideal']:.2f})"
            jobs = [int(jobs) for jobs in row["shapes_per_second"]]
            rates.plot(jobs, list(row["shapes_per_second"].values()), marker="o", label=name)
        else:
            seconds = [point["seconds"] for point in row["curve"]]
            for key, name in (("storing_mb", "stores"), ("worker_mb", "largest worker")):
                memory.plot(seconds, [point[key] for point in row["curve"]], label=name)
            memory.set(title=f"memory over {row['size']:,} small shapes", xlabel="seconds", ylabel="MB")
            memory.set_ylim(bottom=0)
    rates.set(title="indexing", xlabel="worker processes", ylabel="shapes per second", xticks=[1, 2])
    rates.set_ylim(bottom=0)
    for axes in (rates, memory):
        label(axes)
    return figure
