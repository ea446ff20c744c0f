# SPDX-License-Identifier: MIT
"""Measure how right the time is that indexing a .blend file of many objects says is left.

    python -m benchmarks foretold [--objects N]

Needs a Python with the module bpy. A file of N objects is made: things of all kinds of `benchmarks.objects`,
some with a modifier; half of the objects share a mesh with another, and a tenth are instances of collections.
The add-on indexes it in another process, as *Index Library* does. Prints the number of objects and meshes,
the time, and by how much the time foretold was wrong at a quarter, half and three quarters of it.
"""

from __future__ import annotations

import argparse
import importlib
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.blender import enable_addon
from benchmarks.experiments.pauses import Slices, add_options, watch
from benchmarks.objects import OBJECT_KINDS, make_object

__all__ = ["add_options", "fill_scene", "run"]

# Of all objects, those with the mesh of another, and those that are instances of a collection.
SHARING, INSTANCES = 0.5, 0.1
# Objects of a collection that is instanced.
PARTS = 3
# A modifier of every so-manieth mesh makes it larger.
SUBDIVIDED = 7


def fill_scene(count: int) -> None:
    """Fill an empty scene with objects of all kinds.

    Parameters
    ----------
    count : int
        Number of objects.
    """
    import bpy

    random = np.random.default_rng(count)
    collection = bpy.context.scene.collection
    groups: list[Any] = []
    meshes: list[Any] = []
    for number in range(count):
        name, chance = f"Thing {number:05}", random.random()
        if groups and chance < INSTANCES:
            item = bpy.data.objects.new(name, None)
            item.instance_type = "COLLECTION"
            item.instance_collection = groups[random.integers(len(groups))]
        elif meshes and chance < INSTANCES + SHARING:
            item = bpy.data.objects.new(name, meshes[random.integers(len(meshes))])
        else:
            item = bpy.data.objects.new(name, _new_mesh(name, number))
            meshes.append(item.data)
            if number % SUBDIVIDED == 0:
                item.modifiers.new("Subdivision", "SUBSURF")
        item.location = (number % 50 * 3, number // 50 * 3, 0)
        collection.objects.link(item)
        if len(meshes) % 100 == PARTS and len(groups) < len(meshes) // 100 + 1:
            group = bpy.data.collections.new(f"Group {len(groups):03}")
            for data in meshes[-PARTS:]:
                group.objects.link(bpy.data.objects.new(f"Part of {group.name}", data))
            groups.append(group)
    bpy.context.view_layer.update()


def _new_mesh(name: str, number: int) -> Any:
    import bpy

    mesh = make_object(OBJECT_KINDS[number % len(OBJECT_KINDS)], number)
    data = bpy.data.meshes.new(name)
    data.from_pydata(mesh.vertices.tolist(), [], mesh.faces.tolist())
    return data


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

    with tempfile.TemporaryDirectory() as folder:
        bpy.ops.wm.read_homefile(use_empty=True)
        enable_addon()
        fill_scene(options.objects)
        objects, meshes = len(bpy.data.objects), len(bpy.data.meshes)
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder, "things.blend")))
        jobs = importlib.import_module("blender_addon.jobs")
        arguments = ["index", folder, "--library", str(Path(folder, "library.sglib"))]
        found = watch(jobs.BackgroundRun(arguments), Slices())
        jobs.stop_all()
    print(f"{objects:,} objects with {meshes:,} meshes: {found}", flush=True)
    return 0
