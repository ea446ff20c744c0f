# SPDX-License-Identifier: MIT
"""Draw docs/images/signatures.png: what the add-on paints, on creatures in several poses (paper, figure 5).

    python -m benchmarks.figures.signatures [--output FILE.png]

Needs a Python with the `bpy` module, this package and scikit-image.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from benchmarks.blender import enable_addon
from benchmarks.creatures import Creature, make_creature, rigs
from benchmarks.figures import workbench
from shapegoogle_core.rendering import contact_sheet

__all__ = ["main"]

OUTPUT = Path(__file__).resolve().parents[2] / "docs" / "images" / "signatures.png"
TILE = (176, 158)
INDIVIDUAL, VERTICES = 2011, 6000
SHAPES = (("horse", "rest"), ("horse", "gallop"), ("horse", "graze"), ("human", "rest"), ("octopus", "rest"))
# Heat spreads from the vertex of the rest pose that is furthest this way: the nose, the top of the head.
SOURCES = {"horse": (0.0, -1.0, 1.0), "human": (0.0, 0.0, 1.0), "octopus": (0.0, 0.0, 1.0)}
# What the settings of the panel Signature are set to, and the words under the pictures.
ROWS = (
    ({"kind": "HKS", "scale": 0.3}, "heat kernel signature"),
    ({"kind": "RGB"}, "HKS as red, green, blue"),
    ({"kind": "WORDS"}, "geometric words"),
    ({"kind": "HEAT", "scale": 0.5}, "heat from one vertex"),
)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--output", type=Path, default=OUTPUT, help="the picture (%(default)s)")
    options = parser.parse_args()
    missing = workbench.missing_library()
    if missing:
        print(f"Workbench needs the system library {missing}; install it first", file=sys.stderr)
        return 1
    enable_addon()
    bpy.ops.wm.read_homefile(use_empty=True)
    creatures = {kind: make_creature(kind, INDIVIDUAL, VERTICES) for kind, _ in SHAPES}
    items = [add_object(creatures[kind], pose) for kind, pose in SHAPES]
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
    sheet.save(options.output, optimize=True)
    print(f"{options.output}: {options.output.stat().st_size / 1000:.0f} kB")
    return 0


def add_object(creature: Creature, pose: str) -> Any:
    """Add a creature in a pose, with the vertex selected that heat spreads from: the same in every pose."""
    item = bpy.data.objects.new(creature.kind, rigs.mesh_data(creature.pose(pose), creature.kind))
    bpy.context.scene.collection.objects.link(item)
    rest = creature.rest.vertices
    selected = np.zeros(len(rest), bool)
    selected[(rest @ SOURCES[creature.kind]).argmax()] = True
    item.data.vertices.foreach_set("select", selected)
    return item


if __name__ == "__main__":
    sys.exit(main())
