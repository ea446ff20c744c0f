# SPDX-License-Identifier: MIT
"""Measure for how long at a stretch one large mesh keeps the window from answering.

    python -m benchmarks large-mesh [--vertices N]

Needs a Python with the module bpy. A surface of about N vertices, once in triangles and once in quads, is
read for a search or a comparison, painted, and compared and linked with a copy of it, also with a copy whose
vertices are in another order; each as the window does it. Prints for each the number of slices of the main
thread and their longest, as `pauses` does.
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.blender import enable_addon
from benchmarks.experiments.pauses import HEADER, Slices, in_slices
from shapegoogle_core.cli.arguments import number_from

__all__ = ["add_options", "run"]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--vertices",
        metavar="N",
        type=number_from(100),
        default=500_000,
        help="number of vertices, about (%(default)s)",
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

    enable_addon()
    jobs = importlib.import_module("blender_addon.jobs")
    # The window does so in another thread when a panel is drawn for the first time.
    importlib.import_module("shapegoogle_core.worker.requests")
    for quads in (False, True):
        bpy.ops.wm.read_homefile(use_empty=True)
        first = _surface("Large", options.vertices, quads=quads)
        same, other = (_copy_of(first, name) for name in ("Same order", "Other order"))
        _shuffle(other.data)
        bpy.context.view_layer.update()
        faces = len(first.data.polygons)
        print(f"{len(first.data.vertices):,} vertices, {faces:,} {'quads' if quads else 'triangles'}")
        print(HEADER, flush=True)
        for line in (_read(first), _paint(first), *_link([first, same]), *_link([first, other])):
            print(line, flush=True)
    jobs.stop_all()
    return 0


def _surface(name: str, vertices: int, *, quads: bool) -> Any:
    """Make a wavy square without symmetry, the active object."""
    import bpy

    side = round(vertices**0.5)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=side - 1, y_subdivisions=side - 1, size=10)
    item = bpy.context.object
    item.name, data = name, item.data
    places = np.empty((len(data.vertices), 3), np.float32)
    data.vertices.foreach_get("co", places.ravel())
    places[:, 2] = np.sin(places[:, 0]) * np.cos(1.3 * places[:, 1]) + 0.03 * places[:, 0] ** 2
    data.vertices.foreach_set("co", places.ravel())
    if not quads:
        item.modifiers.new("Triangulate", "TRIANGULATE")
        bpy.ops.object.modifier_apply(modifier="Triangulate")
    return item


def _copy_of(item: Any, name: str) -> Any:
    import bpy

    made = bpy.data.objects.new(name, item.data.copy())
    bpy.context.scene.collection.objects.link(made)
    return made


def _shuffle(data: Any) -> None:
    """Put the vertices, edges and faces of a mesh into another order."""
    import bmesh

    edited = bmesh.new()
    edited.from_mesh(data)
    random = np.random.default_rng(0)
    for elements in (edited.verts, edited.edges, edited.faces):
        order = random.permutation(len(elements)).tolist()
        for element, place in zip(elements, order, strict=True):
            element.index = place
        elements.sort()
    edited.to_mesh(data)
    edited.free()


def _read(item: Any) -> str:
    import bpy

    from blender_addon.scene.query import object_steps

    slices = Slices()
    in_slices(object_steps(item, bpy.context), slices)
    return slices.line("read")


def _paint(item: Any) -> str:
    import bpy

    from blender_addon.jobs import worker
    from blender_addon.signature import painting, results
    from blender_addon.signature.painter import Painter
    from blender_addon.signature.properties import settings_of

    bpy.context.scene.shape_google_painting.kind = "HKS"
    chosen = settings_of(bpy.context.scene)
    slices = Slices()
    painter = Painter()
    painter._failed = []
    in_slices(painter._keep_tasks(bpy.context, [item]), slices)
    assert painter._tasks is not None
    for task in painter._tasks:
        result = worker().submit(task.function, *task.arguments).result()
        slices.timed(lambda task=task, result=result: results.remember(task, result))  # type: ignore[misc]

    def paint() -> None:
        entry = results.known(results.key_of(item, chosen, None))
        assert entry is not None
        painting.apply(item, chosen, entry)
        bpy.context.view_layer.update()

    slices.timed(paint)
    return slices.line("paint")


def _link(items: list[Any]) -> Iterator[str]:
    import bpy

    from blender_addon.duplicates.groups import Collecting
    from blender_addon.duplicates.linking import LinkRun

    find = Slices()
    collection = find.timed(lambda: Collecting(bpy.context, items))
    in_slices(collection.steps(), find)
    order = items[1].name.lower()
    yield find.line(f"compare, {order}")
    slices = Slices()
    task = slices.timed(lambda: LinkRun(bpy.context, [items]))
    in_slices(task.steps(), slices)
    yield slices.line(f"link, {order}", f"linked {len(task.result.linked)}")
