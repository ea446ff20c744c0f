# SPDX-License-Identifier: MIT
"""Measure for how long at a stretch the window is kept from answering, and how right the progress is.

    python -m benchmarks pauses [--objects N]

Needs a Python with the module bpy. A scene of N objects, half of them copies of the other half, is saved and
indexed from its file in another process, then indexed as it is, searched, checked for new objects and linked,
and a scatter of 50,000 boxes is read for a search, each as the window does it: in slices on the main thread,
after another thread has imported the core. Prints for each the number of slices, their longest in
milliseconds of processor time of the main thread, which does not count what other programs do, and of wall
time; for indexing also the difference between the time that the progress foretold and the time it took, at a
quarter, half and three quarters of it. Searches print the processor time of the worker process.
"""

from __future__ import annotations

import argparse
import importlib
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from benchmarks.blender import enable_addon
from benchmarks.experiments.large_scene import pairs
from shapegoogle_core.cli.arguments import number_from

__all__ = ["HEADER", "Slices", "add_options", "foretold", "in_slices", "run", "watch"]

T = TypeVar("T")

HEADER = f"{'task':24}  slices  longest ms  (wall ms)"
"""Above lines of `Slices.line`."""

# As between the looks of the window.
SECONDS_BETWEEN_LOOKS = 0.25
# Boxes in a row of the scatter, which is a square.
BOXES_IN_ROW = 223


@dataclass
class Slices:
    """Times of the slices of a task.

    Attributes
    ----------
    cpu, wall : list of float
        Seconds.
    """

    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)

    def timed(self, task: Callable[[], T]) -> T:
        """Run a slice and note its time.

        Parameters
        ----------
        task : callable

        Returns
        -------
        result
        """
        wall, cpu = time.perf_counter(), time.thread_time()
        result = task()
        self.cpu.append(time.thread_time() - cpu)
        self.wall.append(time.perf_counter() - wall)
        return result

    def line(self, name: str, rest: str = "") -> str:
        """Describe them in a line."""
        cpu, wall = (1e3 * max(times, default=0.0) for times in (self.cpu, self.wall))
        return f"{name:24}{len(self.cpu):8,}{cpu:12.0f}{wall:12.0f}   {rest}".rstrip()


def foretold(progress: list[tuple[float, float]], seconds: float) -> str:
    """Say how wrong the progress was.

    Parameters
    ----------
    progress : list of (float, float)
        Seconds that had passed, and those that were said to be left.
    seconds : float
        How long it took in the end.

    Returns
    -------
    text : str
        Relative errors of the whole time at a quarter, half and three quarters of it.

    Examples
    --------
    >>> from benchmarks.experiments.pauses import foretold
    >>> foretold([(2.0, 7.0), (5.0, 5.0), (8.0, 3.0)], 10.0)
    'foretold +0 % +0 % +10 %'
    """
    errors = []
    for share in (0.25, 0.5, 0.75):
        later = [entry for entry in progress if entry[0] >= share * seconds]
        passed, left = later[0] if later else (seconds, 0.0)
        errors.append(f"{100 * ((passed + left) / seconds - 1):+.0f} %")
    return f"foretold {' '.join(errors)}"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--objects",
        metavar="N",
        type=number_from(4),
        default=2_000,
        help="number of objects (%(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Measure and print.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    import bpy

    print(HEADER, flush=True)
    with tempfile.TemporaryDirectory() as folder:
        bpy.ops.wm.read_homefile(use_empty=True)
        addon = enable_addon()
        preferences = bpy.context.preferences.addons[addon.__name__].preferences
        preferences.library = str(Path(folder, "library.sglib"))
        preferences.use_asset_libraries = False
        pairs(options.objects)
        file = Path(folder, "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=str(file))
        jobs = importlib.import_module("blender_addon.jobs")
        # The window does so in another thread when a panel is drawn for the first time.
        importlib.import_module("shapegoogle_core.worker.requests")
        for line in _lines(preferences, file):
            print(line, flush=True)
        jobs.stop_all()
    return 0


def _lines(preferences: Any, file: Path) -> Iterator[str]:
    yield _index_file(preferences, file)
    yield _index_scene(preferences)
    yield from _find(preferences)
    yield _check()
    yield _link()
    yield _read_scatter()


def watch(task: Any, slices: Slices) -> str:
    """Take the events of a run of indexing until it ends.

    Parameters
    ----------
    task : BackgroundRun or SceneIndexing
    slices : Slices
        Gets the times that this takes.

    Returns
    -------
    text : str
        How wrong its progress was, and how long it took; see `foretold`.

    Raises
    ------
    RuntimeError
        If it fails.
    """
    from shapegoogle_core.indexing import IndexingProgress

    started = time.monotonic()
    progress: list[tuple[float, float]] = []
    while task.exit_code is None:
        for event in slices.timed(task.events):
            if isinstance(event, IndexingProgress) and event.seconds_left is not None:
                progress.append((time.monotonic() - started, event.seconds_left))
        time.sleep(SECONDS_BETWEEN_LOOKS)
    seconds = time.monotonic() - started
    if task.exit_code:
        raise RuntimeError(f"indexing has ended with {task.exit_code}: {task.last_words()}")
    return f"{foretold(progress, seconds)} of {seconds:.0f} s"


def _index_file(preferences: Any, file: Path) -> str:
    from blender_addon.jobs import BackgroundRun

    slices = Slices()
    arguments = ["index", str(file.parent), "--library", preferences.library]
    task = slices.timed(lambda: BackgroundRun(arguments))
    return slices.line("index the file", watch(task, slices))


def _index_scene(preferences: Any) -> str:
    import bpy

    from blender_addon.library.scene_source import SceneIndexing

    slices = Slices()
    path = Path(preferences.library)
    task = slices.timed(lambda: SceneIndexing(bpy.context, path, "default"))
    return slices.line("index the scene", watch(task, slices))


def _find(preferences: Any) -> Iterator[str]:
    import bpy

    from blender_addon.jobs import worker
    from blender_addon.scene.query import query_meshes
    from blender_addon.search import answer as shown
    from shapegoogle_core.worker import requests

    path = Path(preferences.library)
    bpy.ops.object.select_all(action="DESELECT")
    item = bpy.context.scene.objects[0]
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    slices = Slices()
    # The first search loads the library, which the window does when its panel is drawn.
    times: list[float] = []
    for _ in range(4):
        before = worker().submit(time.process_time).result()
        meshes = slices.timed(lambda: query_meshes(bpy.context))
        answer = worker().submit(requests.query, path, meshes, 24).result()
        slices.timed(lambda answer=answer: shown.show_answer(bpy.context, answer, 0.0))  # type: ignore[misc]
        first = answer.matches[: shown.EXPLAINED_AT_ONCE]
        found = worker().submit(requests.explain, path, answer.signatures, first).result()
        slices.timed(lambda found=found: shown.show_evidence(bpy.context, found))  # type: ignore[misc]
        times.append(worker().submit(time.process_time).result() - before)
    best = sorted(times[1:])[1]
    yield slices.line(
        "find similar", f"worker {best:.2f} s with {len(first)} kinds in {answer.shape_count:,}"
    )


def _check() -> str:
    import bpy

    from blender_addon.new_objects.known import objects_to_check
    from blender_addon.new_objects.operators import Check

    slices = Slices()
    check = slices.timed(
        lambda: Check(bpy.context, objects_to_check(bpy.context, "NOT_INDEXED", frozenset()))
    )
    while True:
        groups, meshes = slices.timed(lambda: check.read(bpy.context))
        if not groups and not meshes:
            return slices.line("check new objects")


def _link() -> str:
    import bpy

    from blender_addon.duplicates.groups import Collecting, scene_groups
    from blender_addon.duplicates.linking import LinkRun
    from blender_addon.duplicates.members import objects_by_name, objects_of
    from blender_addon.duplicates.properties import show_groups

    shown = bpy.context.window_manager.shape_google_duplicates
    shown.similar = False
    find = Slices()
    collection = find.timed(lambda: Collecting(bpy.context, bpy.context.scene.objects))
    in_slices(collection.steps(), find)
    find.timed(lambda: show_groups(shown, scene_groups(collection.found), "SCENE"))
    names = objects_by_name(bpy.context)
    groups = [objects_of(bpy.context, group, names, "SCENE") for group in shown.groups if group.linkable]
    slices = Slices()
    task = slices.timed(lambda: LinkRun(bpy.context, groups))
    in_slices(task.steps(), slices)
    # What Blender itself takes to draw the scene again once a single object has another mesh.
    first, *_, last = bpy.context.scene.objects
    first.data = last.data
    redraw = Slices()
    redraw.timed(bpy.context.view_layer.update)
    rest = f"of which Blender's own update after one change {1e3 * redraw.cpu[0]:.0f} ms"
    return "\n".join((find.line("find duplicates"), slices.line("link data", rest)))


def _read_scatter() -> str:
    import bpy

    from blender_addon.scene.query import query_steps

    tree = bpy.data.node_groups.new("Boxes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    kinds = ("MeshGrid", "InstanceOnPoints", "MeshCube")
    grid, places, box = (tree.nodes.new(f"GeometryNode{kind}") for kind in kinds)
    output = tree.nodes.new("NodeGroupOutput")
    for axis in "XY":
        grid.inputs[f"Vertices {axis}"].default_value = BOXES_IN_ROW
        grid.inputs[f"Size {axis}"].default_value = 2 * BOXES_IN_ROW
    tree.links.new(grid.outputs["Mesh"], places.inputs["Points"])
    tree.links.new(box.outputs["Mesh"], places.inputs["Instance"])
    tree.links.new(places.outputs["Instances"], output.inputs[0])
    item = bpy.data.objects.new("Boxes", bpy.data.meshes.new("Boxes"))
    bpy.context.scene.collection.objects.link(item)
    item.modifiers.new("Boxes", "NODES").node_group = tree
    bpy.ops.object.select_all(action="DESELECT")
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    bpy.context.view_layer.update()
    slices = Slices()
    faces = []

    def steps() -> Iterator[object]:
        meshes = yield from query_steps(bpy.context)
        faces.append(len(meshes[0].faces))

    in_slices(steps(), slices)
    return slices.line("read a scatter", f"{BOXES_IN_ROW**2:,} instances with {faces[0]:,} faces")


def in_slices(steps: Iterator[object], slices: Slices) -> None:
    """Work as `time_slices.InSlices` does.

    Parameters
    ----------
    steps : iterator
    slices : Slices
        Gets the times that this takes.
    """
    from blender_addon.time_slices import next_slice

    while slices.timed(lambda: next_slice(steps, time.thread_time)):
        pass
