# SPDX-License-Identifier: MIT
"""Measure the time from a mesh file to a signature, stage by stage.

For each number of vertices, a creature that nothing was learnt from is written as binary PLY and as OBJ. A
new process reads and describes each file with the shipped model on one thread. The rows have the processor
time of every stage, as medians over the repeats, and the peak memory of the first repeat (Linux only).
Imports do not count.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import wraps
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

import shapegoogle_core as sg
from benchmarks.speed.measuring import Options, Row
from benchmarks.speed.meshes import creature, write_mesh
from benchmarks.speed.processes import figures_of
from benchmarks.speed.reporting import panels
from shapegoogle_core.model import shape_bags as bags
from shapegoogle_core.model import shape_model as model
from shapegoogle_core.model import working_shape as working
from shapegoogle_core.model.settings import DESCRIPTORS
from shapegoogle_core.preprocessing import steps
from shapegoogle_core.processes.launching import single_threaded
from shapegoogle_core.registration import LocalWords
from shapegoogle_core.views import ViewModel
from shapegoogle_core.views.network_views import NetworkViews

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["REPEATS", "SIZES", "STAGES", "draw", "measure"]

STAGES = (
    "reading",
    "preprocessing",
    "simplifying",
    "smoothing",
    "spectrum",
    "descriptors",
    "words",
    "bags",
    "sample",
    "codes",
    "views",
    "network",
)
"""In order of execution. "bags" is the rest of `shape_bags`, without descriptors and words; "views" that of
`ViewModel.describe`, without the network."""

# Functions of each stage; time in an inner function does not count for the outer one.
WATCHED: tuple[tuple[Any, str, str], ...] = (
    (sg, "read_mesh", "reading"),
    (working, "prepare", "preprocessing"),
    (steps, "resample", "simplifying"),
    (steps, "smooth", "smoothing"),
    (working, "compute_spectrum", "spectrum"),
    (bags, "soft_words", "words"),
    (model, "shape_bags", "bags"),
    (model, "sample_surface", "sample"),
    (sg.ShapeModel, "codes", "codes"),
    (LocalWords, "code", "codes"),
    (ViewModel, "describe", "views"),
    (NetworkViews, "describe", "network"),
    (ViewModel, "code", "codes"),
)

# The ten colours of matplotlib, and two more.
_COLORS = (*(f"C{number}" for number in range(10)), "#aec7e8", "#ffbb78")
FORMATS = (".ply", ".obj")
GOALS = {1_000: 0.12, 10_000: 0.45, 100_000: 1.2, 1_000_000: 12.0}  # seconds of one core
SIZES, REPEATS = tuple(GOALS), 5


def measure(options: Options) -> Iterator[Row]:
    """Measure all sizes in both formats.

    Parameters
    ----------
    options : Options
        Sizes are numbers of vertices. The folder needs 120 bytes for each.

    Yields
    ------
    row : dict
        For each file. "stages" are seconds of processor time, "total" includes work outside all stages,
        "start" is the time before the first file (imports, loading the model, describing a sphere), and
        "peak_mb" is the peak memory of the process.
    """
    with tempfile.TemporaryDirectory(dir=options.folder) as folder, single_threaded():
        for size in options.sizes:
            mesh = creature(size)
            for suffix in FORMATS:
                path = Path(folder, f"{size}{suffix}")
                write_mesh(mesh, path)
                with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
                    row = process.submit(describe_file, path, options.repeats).result()
                path.unlink()
                yield {"size": size, "format": suffix, "repeats": options.repeats} | row


class StageClock:
    """Processor time of nested functions, each without the inner ones.

    Attributes
    ----------
    seconds : dict of str to float
        By the name of the stage.
    """

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self._open: list[str] = []
        self._since = 0.0

    @contextmanager
    def running(self, stage: str) -> Iterator[None]:
        """Count the time inside the block for a stage."""
        self._count()
        self._open.append(stage)
        try:
            yield
        finally:
            self._count()
            self._open.pop()

    def watch(self, stage: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function with its time counted for a stage."""

        @wraps(function)
        def watched(*arguments: Any, **options: Any) -> Any:
            with self.running(stage):
                return function(*arguments, **options)

        return watched

    def _count(self) -> None:
        now = time.process_time()
        if self._open:
            self.seconds[self._open[-1]] += now - self._since
        self._since = now


def describe_file(path: Path, repeats: int) -> Row:
    """Read and describe a file repeatedly; runs in a new process."""
    import trimesh

    shipped = sg.load_model()
    sphere = trimesh.creation.icosphere(4)
    shipped.describe(sg.Mesh(sphere.vertices, sphere.faces))  # triggers all deferred imports
    start = time.process_time()
    totals, clocks = [], []
    for repeat in range(repeats):
        clock = StageClock()
        with ExitStack() as stack:
            for owner, name, stage in WATCHED:
                stack.enter_context(patch.object(owner, name, clock.watch(stage, getattr(owner, name))))
            watched = {name: clock.watch("descriptors", value) for name, value in DESCRIPTORS.own.items()}
            stack.enter_context(patch.dict(DESCRIPTORS.own, watched))
            started = time.process_time()
            mesh = sg.read_mesh(path)
            shipped.describe(mesh)
            totals.append(time.process_time() - started)
        clocks.append(clock.seconds)
        if repeat == 0:
            figures = figures_of()
    row: Row = {
        "faces": len(mesh.faces),
        "stages": {stage: round(statistics.median(each[stage] for each in clocks), 4) for stage in STAGES},
        "total": round(statistics.median(totals), 4),
        "totals": [round(total, 4) for total in totals],
        "start": round(start, 2),
    }
    if figures is not None:
        row["peak_mb"] = round(figures.peak_mb)
    return row


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the stages as stacked bars, with the largest acceptable times.

    Parameters
    ----------
    rows : sequence of dict
        From `measure`.

    Returns
    -------
    figure : matplotlib.figure.Figure
    """
    sizes = list(dict.fromkeys(row["size"] for row in rows))
    figure, axes = panels(len(sizes), 2.6 * len(sizes) + 1.6, 4.2)
    for panel, size in zip(axes, sizes, strict=True):
        files = [row for row in rows if row["size"] == size]
        names = [row["format"] for row in files]
        bottom = np.zeros(len(files))
        for index, stage in enumerate(STAGES):
            heights = np.array([row["stages"][stage] for row in files])
            panel.bar(names, heights, 0.6, bottom=bottom, color=_COLORS[index], label=stage)
            bottom += heights
        others = np.array([row["total"] for row in files]) - bottom
        panel.bar(names, np.maximum(others, 0), 0.6, bottom=bottom, color="0.8", label="the rest")
        if size in GOALS:
            panel.axhline(GOALS[size], color="black", linestyle=":", label="at most")
        panel.set(title=f"{size:,} vertices")
    axes[0].set_ylabel("seconds of processor time")
    once = dict(zip(*reversed(axes[-1].get_legend_handles_labels()), strict=True))
    # In the order of the bars, with the last stage on top.
    figure.legend(list(once.values())[::-1], list(once)[::-1], loc="outside right center", fontsize="small")
    return figure
