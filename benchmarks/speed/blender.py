# SPDX-License-Identifier: MIT
"""Measure waiting times in Blender: for its start, for matches, for painted attributes.

It needs a Python with the module bpy, such as that of the nox session addon-4.5.

start  time that enabling the add-on adds to the start of Blender, each time in a new process
find   Find Similar with one selected creature, in a library of `SHAPES` synthetic shapes with pictures: the
       main thread before and after the worker process, during which the window is frozen; the worker; and
       its parts: description, search and pictures
paint  heat kernel signatures on the vertices of the same creature with the panel's default settings: main
       thread and worker as above
"""

from __future__ import annotations

import importlib
import io
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from benchmarks.blender import enable_addon
from benchmarks.errors import BenchmarkError
from benchmarks.speed.measuring import Options, Row, installed
from benchmarks.speed.meshes import KIND, SEED
from benchmarks.speed.reporting import panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["REPEATS", "SIZES", "draw", "measure"]

T = TypeVar("T")

SIZES, REPEATS = (10_000, 100_000), 5
ROOT = Path(__file__).resolve().parents[2]
BPY_PYTHON = (
    "run it with .nox/addon-4-5/bin/python, made by: python -m nox --session addon-4.5 --install-only"
)
SHAPES = 1_000
# Largest number of vertices of a creature; larger meshes are subdivided.
LARGEST_CREATURE = 25_000
# Longest acceptable waiting times in seconds.
GOALS = {("find", 10_000): 1.0, ("find", 100_000): 2.0, ("paint", 100_000): 3.0}

START = """
import json, os, sys, time
sys.path.insert(0, {root!r})
import bpy
import addon_utils
numpy = "numpy" in sys.modules
wall, cpu = time.perf_counter(), time.process_time()
enabled = addon_utils.enable("blender_addon", default_set=True)
cpu, wall = 1e3 * (time.process_time() - cpu), 1e3 * (time.perf_counter() - wall)
result = {{"had_numpy": numpy, "cpu": cpu, "wall": wall}} if enabled else None
print("\\nspeed-blender", json.dumps(result), flush=True)
os._exit(0)
"""


def measure(options: Options) -> Iterator[Row]:
    """Measure all parts.

    Parameters
    ----------
    options : Options
        Sizes are approximate numbers of vertices of the query and the painted object. The folder needs about
        30 MB for a library.

    Yields
    ------
    row : dict
        With "part". Times in milliseconds: "cpu" is processor time of the main thread's process or of the
        worker's, "wall" is wall time. "load" is the system's load average.

    Raises
    ------
    BenchmarkError
        If this Python has no module bpy.
    """
    if not installed("bpy"):
        raise BenchmarkError(f"{sys.executable} has no module bpy; {BPY_PYTHON}")
    yield measure_start(options.repeats)
    enable_addon()
    with tempfile.TemporaryDirectory(dir=options.folder) as place:
        library = Path(place) / "made-up.sglib"
        fill(library)
        use_library(library)
        for size in options.sizes:
            select_creature(size)
            yield measure_find(library, options.repeats)
            yield measure_paint(options.repeats)
        module("jobs").stop_all()


def module(name: str) -> ModuleType:
    """Return a module of the add-on."""
    return importlib.import_module(f"blender_addon.{name}")


class Stopwatch:
    """Collects times by name and gives their medians in milliseconds.

    Attributes
    ----------
    times : dict of str to list of float
        Milliseconds.
    """

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = {}

    @contextmanager
    def timed(self, name: str) -> Iterator[None]:
        """Measure the time inside the block."""
        wall, cpu = time.perf_counter(), time.process_time()
        yield
        self.note(f"{name}_cpu", time.process_time() - cpu)
        self.note(f"{name}_wall", time.perf_counter() - wall)

    def note(self, name: str, seconds: float) -> None:
        """Record a time measured elsewhere."""
        self.times.setdefault(name, []).append(1e3 * seconds)

    def ask(self, name: str, function: Callable[..., T], *arguments: object) -> T:
        """Run a task in the worker process and record its wall time and the worker's processor time."""
        worker = module("jobs").worker()
        cpu = worker.submit(time.process_time).result()
        wall = time.perf_counter()
        result: T = worker.submit(function, *arguments).result()
        self.note(f"{name}_wall", time.perf_counter() - wall)
        self.note(f"{name}_cpu", worker.submit(time.process_time).result() - cpu)
        return result

    def add_up(self, name: str, parts: Sequence[str]) -> None:
        """Add the times of consecutive steps, for each repetition."""
        for kind in ("cpu", "wall"):
            columns = (self.times[f"{part}_{kind}"] for part in parts)
            self.times[f"{name}_{kind}"] = [sum(times) for times in zip(*columns, strict=True)]

    def row(self, part: str, **about: Any) -> Row:
        """Make a row of the medians."""
        medians = {name: round(statistics.median(values), 1) for name, values in self.times.items()}
        return {"part": part, **about, **medians, "load": load()}


def load() -> float | None:
    """Return the load average of the last minute; None where the system has none."""
    return round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None


# -- start --------------------------------------------------------------------------------------------------


def measure_start(repeats: int) -> Row:
    """Enable the add-on in new processes."""
    import bpy

    code = START.format(root=str(ROOT))
    command = [sys.executable, "-c", code]
    if bpy.app.binary_path:
        command = [bpy.app.binary_path, "--background", "--factory-startup", "--python-expr", code]
    watch = Stopwatch()
    had_numpy = False
    # The first run may compile files, so it does not count.
    for number in range(repeats + 1):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        found = [line for line in done.stdout.splitlines() if line.startswith("speed-blender ")]
        result = json.loads(found[0].partition(" ")[2]) if found else None
        if result is None:
            raise RuntimeError(f"another Blender cannot enable the add-on:\n{done.stdout}{done.stderr}")
        had_numpy = result["had_numpy"]
        if number:
            watch.note("cpu", result["cpu"] / 1e3)
            watch.note("wall", result["wall"] / 1e3)
    return watch.row("start", blender=bpy.app.version_string, had_numpy=had_numpy)


# -- the library and the query -------------------------------------------------------------------------------


def fill(path: Path) -> None:
    """Make a library of synthetic shapes, with samples and pictures like real ones."""
    import numpy as np
    from PIL import Image

    import shapegoogle_core as sg
    from benchmarks.creatures import make_creature
    from benchmarks.speed.search import made_up_signature
    from shapegoogle_core.library.storage.records import NewShape

    model = sg.load_model()
    like = model.describe(make_creature(KIND, SEED, 3_000).pose(SEED))
    picture = io.BytesIO()
    colors = np.random.default_rng(0).integers(0, 256, (128, 128, 4), np.uint8)
    Image.fromarray(colors, "RGBA").save(picture, "PNG")
    with sg.Library.open(path, model) as library:
        shapes = [
            NewShape(made_up_signature(model, like, seed), f"shape {seed}", thumbnail=picture.getvalue())
            for seed in range(SHAPES)
        ]
        library.replace_source("made-up", size=0, mtime_ns=0, sha256=None, shapes=shapes)


def use_library(path: Path) -> None:
    """Set the library in the preferences and let the worker open it, as drawing the panel does."""
    import bpy

    from shapegoogle_core.worker.requests import library_state, warm_up

    bpy.context.preferences.addons["blender_addon"].preferences.library = str(path)
    worker = module("jobs").worker()
    worker.submit(warm_up)
    worker.submit(library_state, path).result()


def select_creature(size: int) -> None:
    """Add a creature to the scene as the only selected object."""
    import bpy
    import trimesh

    import shapegoogle_core as sg
    from benchmarks.creatures import make_creature

    steps = 0
    while size > LARGEST_CREATURE * 4**steps:
        steps += 1
    mesh = make_creature(KIND, SEED, size // 4**steps).pose(SEED)
    for _ in range(steps):
        vertices, faces = trimesh.remesh.subdivide(mesh.vertices, mesh.faces)  # type: ignore[no-untyped-call]
        mesh = sg.Mesh(vertices, faces, mesh.name)
    item = module("scene.meshes").new_object(bpy.context, mesh, f"creature {size}")
    for other in bpy.context.selected_objects:
        other.select_set(False)
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    bpy.context.view_layer.update()


# -- Find Similar and painting ------------------------------------------------------------------------------


def measure_find(path: Path, repeats: int) -> Row:
    """Time the steps of Find Similar with the selected object."""
    import bpy

    import shapegoogle_core as sg
    from shapegoogle_core.worker import requests as tasks

    scene, shown = module("scene.query"), module("search.answer")
    watch = Stopwatch()
    top = bpy.context.window_manager.shape_google.top
    for _ in range(repeats):
        with watch.timed("read"):
            meshes = scene.query_meshes(bpy.context)
        answer = watch.ask("worker", tasks.query, path, meshes, top)
        with watch.timed("show"):
            shown.show_answer(bpy.context, answer, 0.0)
        some = answer.matches[: shown.EXPLAINED_AT_ONCE]
        watch.ask("explain_some", tasks.explain, path, answer.signatures, some)
    watch.add_up("waited", ("read", "worker", "show"))
    # Parts of the worker's time, measured in this process.
    with sg.Library.open(path, read_only=True) as library:
        for _ in range(repeats):
            with watch.timed("describe"):
                signatures = [library.model.describe(mesh, keep_surface=True) for mesh in meshes]
            with watch.timed("search"):
                matches = library.query(signatures, top=top, explain=0)
            with watch.timed("pictures"):
                for match in matches:
                    library.thumbnail(match.shape_id)
    return watch.row("find", vertices=len(meshes[0].vertices), shapes=SHAPES)


def measure_paint(repeats: int) -> Row:
    """Time the steps of painting the selected object."""
    import bpy

    painting, results = module("signature.painting"), module("signature.results")
    known = module("state").current().signature.results
    bpy.context.scene.shape_google_painting.kind = "HKS"
    chosen = module("signature.properties").settings_of(bpy.context.scene)
    item = bpy.context.object
    watch = Stopwatch()
    for _ in range(repeats):
        known.clear()
        with watch.timed("read"):
            task = results.task_of(item, chosen, None, results.key_of(item, chosen, None))
        result = watch.ask("worker", task.function, *task.arguments)
        with watch.timed("show"):
            results.remember(task, result)
            entry = results.known(results.key_of(item, chosen, None))
            painting.apply(item, chosen, entry)
        with watch.timed("slide"):  # a step of the time slider
            painting.repaint(bpy.context, chosen, color=True)
    watch.add_up("waited", ("read", "worker", "show"))
    return watch.row("paint", vertices=len(item.data.vertices), kind=chosen.kind, budget=chosen.budget)


# -- the figure ---------------------------------------------------------------------------------------------


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the parts of the waiting times, in processor time, and the longest acceptable ones.

    Parameters
    ----------
    rows : sequence of dict
        From `measure`.

    Returns
    -------
    figure : matplotlib.figure.Figure
    """
    waits = [row for row in rows if row["part"] != "start"]
    figure, (axes,) = panels(1, 8, 1 + 0.6 * len(waits))
    names = [f"{row['part']}, {row['vertices']:,} vertices" for row in waits]
    start = [0.0] * len(waits)
    for step, label in (("read", "reading the mesh"), ("worker", "worker process"), ("show", "showing")):
        values = [row[f"{step}_cpu"] / 1e3 for row in waits]
        axes.barh(names, values, left=start, label=label)
        start = [one + other for one, other in zip(start, values, strict=True)]
    for place, row in enumerate(waits):
        for (part, size), goal in GOALS.items():
            if part == row["part"] and abs(row["vertices"] - size) < 0.1 * size:
                axes.plot(goal, place, "k|", markersize=24)
    axes.plot([], [], "k|", label="at most")
    axes.invert_yaxis()
    axes.set(xlabel="seconds of processor time", xlim=(0, None))
    axes.legend(fontsize="small")
    return figure
