# SPDX-License-Identifier: MIT
"""
A map of a library
==================

Place the shapes of a library in the plane so that similar ones lie near each other. The distances are those
of the search, by kind; t-SNE turns them into positions.
"""

import io
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.offsetbox import AnnotationBbox, OffsetImage
from PIL import Image
from sklearn.manifold import TSNE

import shapegoogle_core as sg
from benchmarks.objects import make_object
from shapegoogle_core.rendering import thumbnail

kinds = ["chair", "table", "mug", "vase", "sword", "car"]
shapes = [(kind, make_object(kind, seed)) for kind in kinds for seed in range(3)]

# %%
# Every shape asks for all others. ``rank="kind"`` sorts by how likely two shapes are of one kind.

folder = tempfile.TemporaryDirectory()
with sg.Library.open(Path(folder.name, "objects.sglib")) as library:
    numbers = [library.add(shape, name=kind) for kind, shape in shapes]
    place = {number: position for position, number in enumerate(numbers)}
    distances = np.zeros((len(shapes), len(shapes)))
    for number in numbers:
        query = library.signature(number)
        for match in library.query(query, top=len(shapes), explain=0, exact=True, rank="kind"):
            distances[place[number], place[match.shape_id]] = match.distance
folder.cleanup()

# %%
# t-SNE keeps near neighbours near, and pushes the others apart.

layout = TSNE(metric="precomputed", init="random", perplexity=5, random_state=0)
positions = layout.fit_transform((distances + distances.T) / 2)

figure, axes = plt.subplots(figsize=(8, 6))
for (_, shape), position in zip(shapes, positions, strict=True):
    picture = Image.open(io.BytesIO(thumbnail(shape, 96, up_axis=2)))
    axes.add_artist(
        AnnotationBbox(OffsetImage(np.asarray(picture.convert("RGBA")), zoom=0.5), position, frameon=False)
    )
low, high = positions.min(axis=0), positions.max(axis=0)
margin = 0.08 * (high - low)
axes.set(xlim=(low[0] - margin[0], high[0] + margin[0]), ylim=(low[1] - margin[1], high[1] + margin[1]))
axes.set_xticks([])
axes.set_yticks([])
figure.tight_layout()
