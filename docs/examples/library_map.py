# SPDX-License-Identifier: MIT
"""
A map of a library
==================

Place the shapes of a library in the plane so that similar ones lie near each other. The distances are those
of the search, by kind; classical multidimensional scaling turns them into positions.
"""

import io
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.offsetbox import AnnotationBbox, OffsetImage
from PIL import Image

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
# Classical scaling: the two main axes of the doubly centred squared distances.

symmetric = (distances + distances.T) / 2
centring = np.eye(len(shapes)) - 1 / len(shapes)
values, vectors = np.linalg.eigh(-0.5 * centring @ symmetric**2 @ centring)
positions = vectors[:, -2:] * np.sqrt(values[-2:])

figure, axes = plt.subplots(figsize=(8, 6))
for (_, shape), position in zip(shapes, positions, strict=True):
    picture = Image.open(io.BytesIO(thumbnail(shape, 96, up_axis=2)))
    axes.add_artist(
        AnnotationBbox(OffsetImage(np.asarray(picture.convert("RGBA")), zoom=0.5), position, frameon=False)
    )
axes.set(xlim=(positions[:, 0].min() - 0.1, positions[:, 0].max() + 0.1))
axes.set(ylim=(positions[:, 1].min() - 0.1, positions[:, 1].max() + 0.1))
axes.set_xticks([])
axes.set_yticks([])
figure.tight_layout()
