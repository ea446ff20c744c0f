# SPDX-License-Identifier: MIT
"""
Training a small model
======================

A *model* holds all that is learnt: the vocabularies, the metric, the hash functions and the calibration of
similarities. The shipped one serves for most purposes. This example learns a tiny one, with the descriptor
of the paper only, and lets it find a creature that it has never seen.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import make_creature

# %%
# Eight creatures to learn from. Versions of each, with noise, holes and other changes, are made by the
# training itself; a useful model needs hundreds of shapes.

kinds = ["human", "dog", "bird", "lizard", "fish", "octopus", "spider", "hand"]
shapes = [
    sg.TrainingShape(kind, [creature.rest, creature.pose(1)])
    for kind in kinds
    for creature in [make_creature(kind, seed=20, vertex_count=800)]
]

# %%
# The settings are those of the shipped model, with one channel of 24 words and without surfaces for
# evidence. ``jobs=0`` trains in this process; worker processes need a script with the guard ``if __name__
# == "__main__":``.

settings = sg.ModelSettings(
    name="tiny",
    channels=(replace(sg.load_model().settings.channels[0], words=24),),
    eigenpairs=60,
    code_bits=64,
)
model = sg.train_model(shapes, settings, versions=2, jobs=0, trained_on="eight creatures")
print(model)

# %%
# Query with another pose of animals that the model was not trained on. The distance of bags is smallest
# for the right one.

unseen = ["horse", "elephant", "turtle", "starfish"]
creatures = [make_creature(kind, seed=30, vertex_count=800) for kind in unseen]
database = np.stack([model.describe(creature.rest).bags for creature in creatures])
distances = np.stack(
    [model.distances(model.describe(creature.pose(2)).bags, database) for creature in creatures]
)

figure, axes = plt.subplots(figsize=(5, 4))
axes.imshow(distances, cmap="viridis")
for (row, column), distance in np.ndenumerate(distances):
    color = "black" if distance > distances.max() / 2 else "white"
    axes.text(column, row, f"{distance:.2f}", ha="center", va="center", color=color)
axes.set(xticks=range(len(unseen)), xticklabels=unseen, xlabel="at rest, in the database")
axes.set(yticks=range(len(unseen)), yticklabels=unseen, ylabel="query, in another pose")
figure.tight_layout()
