# SPDX-License-Identifier: MIT
"""Figure of the attributes that the add-on paints, on creatures in several poses (paper, figure 5).

Needs the module bpy and scikit-image.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from benchmarks.blender import enable_addon
from benchmarks.creatures import Creature, make_creature, rigs
from benchmarks.errors import BenchmarkError
from benchmarks.figures import workbench
from benchmarks.figures.contact_sheet import contact_sheet

__all__ = ["draw"]

TILE = (176, 158)
INDIVIDUAL, VERTICES = 2011, 6000
SHAPES = (("horse", "rest"), ("horse", "gallop"), ("horse", "graze"), ("human", "rest"), ("octopus", "rest"))
# Direction whose farthest vertex in the rest pose is the heat source: the nose, the top of the head.
SOURCES = {"horse": (0.0, -1.0, 1.0), "human": (0.0, 0.0, 1.0), "octopus": (0.0, 0.0, 1.0)}
# Settings of the panel Signature, and captions.
ROWS = (
    ({"kind": "HKS", "scale": 0.3}, "heat kernel signature"),
    ({"kind": "RGB"}, "HKS as red, green, blue"),
    ({"kind": "WORDS"}, "geometric words"),
    ({"kind": "HEAT", "scale": 0.5}, "heat from one vertex"),
)


def draw(path: Path) -> None:
    """Draw the figure.

    Parameters
    ----------
    path : Path
        The .png file.

    Raises
    ------
    BenchmarkError
        If Blender's Workbench renderer cannot run here.
    """
    missing = workbench.missing_library()
    if missing:
        raise BenchmarkError(f"Workbench needs the system library {missing}; install it first")
    enable_addon()
    bpy.ops.wm.read_homefile(use_empty=True)
    creatures = {kind: make_creature(kind, INDIVIDUAL, VERTICES) for kind, _ in SHAPES}
    items = [_add_object(creatures[kind], pose) for kind, pose in SHAPES]
    for item in items:
        item.select_set(True)
    workbench.set_up_studio(bpy.context.scene)
    images, captions = [], []
    for settings, title in ROWS:
        for name, value in settings.items():
            setattr(bpy.context.scene.shape_google_painting, name, value)
        bpy.ops.shape_google.paint()
        images += [workbench.photograph(item, TILE) for item in items]
        captions += [title, *[""] * (len(items) - 1)]
    sheet = contact_sheet(images, captions, len(items))
    sheet.save(path, optimize=True)


def _add_object(creature: Creature, pose: str) -> Any:
    """Add a creature in a pose, with the heat source selected, the same vertex in every pose."""
    item = bpy.data.objects.new(creature.kind, rigs.mesh_data(creature.pose(pose), creature.kind))
    bpy.context.scene.collection.objects.link(item)
    rest = creature.rest.vertices
    selected = np.zeros(len(rest), bool)
    selected[(rest @ SOURCES[creature.kind]).argmax()] = True
    item.data.vertices.foreach_set("select", selected)
    return item
