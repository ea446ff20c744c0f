# SPDX-License-Identifier: MIT
"""
Finding the whole from a part
=============================

Half of a model, or a selection in Blender, finds the shape that it was taken from. The bags of a part
differ from those of the whole, because heat feels the cut; *local words* and an alignment of the surfaces
find the whole nevertheless.
"""

import tempfile
from pathlib import Path

import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.figures.shape_rows import show_shapes

kinds = ["horse", "deer", "dog", "giraffe", "human", "lizard"]
shapes = {kind: make_creature(kind, seed=3, vertex_count=2_000).pose(1) for kind in kinds}

# %%
# Cut the deer in half across its longest axis, and keep the front.

whole = shapes["deer"]
axis = np.ptp(whole.vertices, axis=0).argmax()
centres = whole.vertices[whole.faces].mean(axis=1)
kept = whole.faces[centres[:, axis] < np.median(whole.vertices[:, axis])]
used, faces = np.unique(kept, return_inverse=True)
half = sg.Mesh(whole.vertices[used], faces.reshape(-1, 3), "half a deer")

# %%
# The evidence says which share of the match the query covers.

folder = tempfile.TemporaryDirectory()
with sg.Library.open(Path(folder.name, "animals.sglib")) as library:
    for kind, shape in shapes.items():
        library.add(shape, name=kind)
    matches = library.query(half, top=3)

for match in matches:
    share = "" if match.evidence.share is None else f", {100 * match.evidence.share:.0f} % of it"
    print(f"{match.similarity:.2f}  {match.name:8}  {match.evidence.kind}{share}")

show_shapes(
    [half] + [shapes[match.name] for match in matches],
    ["query"] + [f"{match.name}: {match.evidence.kind}" for match in matches],
)
folder.cleanup()
