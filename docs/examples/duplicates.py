# SPDX-License-Identifier: MIT
"""
Duplicates in a library
=======================

A library that many people fill contains shapes more than once: copied, scaled, re-meshed, in another pose.
``Library.duplicates`` groups them and says how each member is related to the first.
"""

import tempfile
from pathlib import Path

import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.figures.shape_rows import show_shapes
from benchmarks.objects import make_object

human = make_creature("human", seed=4, vertex_count=2_000)
chair, mug = make_object("chair", seed=2), make_object("mug", seed=2)
shapes = {
    "hero": human.pose("stand"),
    "hero_copy": human.pose("stand"),
    "hero_run": human.pose("run"),
    "chair": chair,
    "chair_large": sg.Mesh(2.5 * chair.vertices, chair.faces),
    "chair_mirrored": sg.Mesh(chair.vertices * [-1, 1, 1], chair.faces[:, ::-1]),
    "mug": mug,
    "mug_moved": sg.Mesh(mug.vertices + np.array([10.0, 0.0, 0.0]), mug.faces),
    "table": make_object("table", seed=2),
}

# %%
# Nothing is deleted: a group is a report.

folder = tempfile.TemporaryDirectory()
with sg.Library.open(Path(folder.name, "studio.sglib")) as library:
    for name, shape in shapes.items():
        library.add(shape, name=name)
    groups = library.duplicates()

for group in groups:
    print(f"{group.kind}:", ", ".join(member.name for member in group.members))

members = [member.name for group in groups for member in group.members]
labels = [f"{group.kind}:\n{member.name}" for group in groups for member in group.members]
show_shapes([shapes[name] for name in members], labels)
folder.cleanup()
