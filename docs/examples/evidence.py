# SPDX-License-Identifier: MIT
"""
Evidence: how two shapes are related
====================================

``sg.compare`` compares two shapes without a library. Here one horse is compared with copies, poses and
relatives of itself.
"""

import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.figures.shape_rows import show_shapes
from benchmarks.objects import make_object

horse = make_creature("horse", seed=5, vertex_count=2_000).pose("walk")
v, f = horse.vertices, horse.faces
turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

others = {
    "copy": sg.Mesh(v, f),
    "turned and moved": sg.Mesh(v @ turn.T + [1, 2, 3], f),
    "twice as large": sg.Mesh(2 * v, f),
    "mirrored": sg.Mesh(v * [-1, 1, 1], f[:, ::-1]),
    "another mesh": make_creature("horse", seed=5, vertex_count=1_200).pose("walk"),
    "another pose": make_creature("horse", seed=5, vertex_count=2_000).pose("rear"),
    "another horse": make_creature("horse", seed=8, vertex_count=2_000).pose("walk"),
    "a chair": make_object("chair", seed=1),
}

# %%
# Each comparison takes about a second. ``deviation`` is the distance of the aligned surfaces in units of
# √area.

captions = []
for name, other in others.items():
    match = sg.compare(horse, other)
    evidence = match.evidence
    deviation = "" if evidence.deviation is None else f", deviation {evidence.deviation:.4f}"
    print(f"{name:17} similarity {match.similarity:.2f}: {evidence.kind} ×{evidence.factor:.2f}{deviation}")
    captions.append(f"{name}\n{evidence.kind}, {match.similarity:.2f}")

show_shapes(list(others.values()), captions)
