# SPDX-License-Identifier: MIT
"""
A small benchmark
=================

The protocol of SHREC 2010, which the paper uses, in small: shapes are changed in several ways and
strengths, and each version has to find its original. ``python -m benchmarks retrieval`` measures the whole
of it, with a report.
"""

import matplotlib.pyplot as plt
import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.figures.shape_rows import show_shapes
from benchmarks.protocol.metrics import ranks, strength_table
from shapegoogle_core.model.augmentation import transform

kinds = ["horse", "dog", "human", "ape", "lizard", "octopus", "crab", "bird"]
nulls = [make_creature(kind, seed=40, vertex_count=1_000).rest for kind in kinds]
model = sg.load_model()
database = np.stack([model.describe(null).bags for null in nulls])

# %%
# Queries: the first four shapes, in four classes and at strengths 1, 3 and 5.

classes, strengths = ["noise", "holes", "local_scale", "partial"], [1, 3, 5]
show_shapes(
    [transform(nulls[0], kind, 5, seed=0) for kind in classes], [f"{kind}, strength 5" for kind in classes]
)

# %%
# Each query has one relevant shape, so its average precision is the reciprocal of the rank of that shape.
# Only the bags are compared here; a library would verify the best candidates by aligning them.

asked = [(null, kind, strength) for null in range(4) for kind in classes for strength in strengths]
distances = [
    model.distances(model.describe(transform(nulls[null], kind, strength, seed=0)).bags, database)
    for null, kind, strength in asked
]
places = ranks(np.array(distances), np.array([null for null, _, _ in asked]))
table = strength_table(places, [kind for _, kind, _ in asked], [strength for _, _, strength in asked])
print("mAP × 100, strengths up to   1      3      5")
for kind, row in table.items():
    print(f"{kind:24} " + " ".join(f"{row[strength - 1]:6.1f}" for strength in strengths))

# %%
# The same as a plot.

figure, axes = plt.subplots(figsize=(6, 3))
for kind in classes:
    axes.plot(strengths, [table[kind][strength - 1] for strength in strengths], marker="o", label=kind)
axes.set(xlabel="queries up to strength", ylabel="mAP × 100", xticks=strengths, ylim=(0, 105))
axes.legend(ncols=2, fontsize=8)
figure.tight_layout()
