# SPDX-License-Identifier: MIT
"""Time *Link Data* and *This Scene* in scenes of many objects, to see that the time grows with their number.

    python -m benchmarks large-scene [--objects N [N ...]]

Needs a Python with the module bpy. Half of the objects are copies of the other half, in pairs; then the same
number of objects share one mesh. Prints the processor time of finding and of linking the copies, and of
indexing the objects of one mesh, each in total and relative to the number of objects.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.blender import enable_addon
from shapegoogle_core.cli.arguments import number_from

__all__ = ["add_options", "run"]

SIZES = (500, 1_000, 2_000)


def pairs(count: int) -> None:
    """Fill an empty scene with pairs of copies; every third copy has its place in the coordinates.

    Parameters
    ----------
    count : int
        Number of objects.
    """
    import bpy
    import numpy as np
    from mathutils import Matrix

    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    ball = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    points = np.empty((len(ball.vertices), 3), np.float32)
    ball.vertices.foreach_get("co", points.ravel())
    for number in range(count):
        data = ball.copy()
        lumps = 1 + 0.3 * np.random.default_rng(number // 2).random((len(points), 1))
        data.vertices.foreach_set("co", (points * lumps).astype(np.float32).ravel())
        place = Matrix.Translation((number % 50 * 3, number // 50 * 3, 0)) @ Matrix.Rotation(number, 4, "Z")
        if number % 3 == 0:
            data.transform(place)
        item = bpy.data.objects.new(f"Part {number:05}", data)
        bpy.context.scene.collection.objects.link(item)
        if number % 3:
            item.matrix_world = place
    bpy.context.view_layer.update()


def share_one_mesh() -> None:
    """Have all objects of the scene show the mesh of the first."""
    import bpy

    first, *others = bpy.context.scene.objects
    for item in others:
        item.data = first.data
    bpy.context.view_layer.update()


def seconds(task: Callable[[], Any]) -> float:
    """Processor time of a task.

    Parameters
    ----------
    task : callable

    Returns
    -------
    seconds : float
    """
    started = time.process_time()
    task()
    return time.process_time() - started


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--objects",
        metavar="N",
        nargs="+",
        type=number_from(2),
        default=SIZES,
        help="numbers of objects (%(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Time and print.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    import bpy

    print("objects   find s   link s   linked   index one mesh s   link ms/object")
    with tempfile.TemporaryDirectory() as folder:
        for count in options.objects:
            bpy.ops.wm.read_homefile(use_empty=True)
            addon = enable_addon()
            preferences = bpy.context.preferences.addons[addon.__name__].preferences
            preferences.library = str(Path(folder, f"{count}.sglib"))
            preferences.use_scene, preferences.use_asset_libraries = True, False
            pairs(count)
            shown = bpy.context.window_manager.shape_google_duplicates
            shown.similar = False
            find = seconds(bpy.ops.shape_google.find_duplicates)
            for group in shown.groups:
                group.chosen = True
            link = seconds(bpy.ops.shape_google.link_duplicates)
            linked = count - len({item.data for item in bpy.context.scene.objects})
            share_one_mesh()
            index = seconds(bpy.ops.shape_google.index_library)
            print(
                f"{count:7,}{find:9.2f}{link:9.2f}{linked:9,}{index:19.2f}{1e3 * link / max(linked, 1):17.1f}"
            )
    return 0
