# SPDX-License-Identifier: MIT
"""
A library in five lines
=======================

Add shapes to a library, then find one of them again in another pose, at another size and with another mesh.
"""

import tempfile
from pathlib import Path

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.figures.shape_rows import show_shapes

# %%
# The shapes are procedural creatures, each in its rest pose. Any mesh file would do:
# ``sg.read_mesh("horse.ply")``.

kinds = ["horse", "deer", "dog", "human", "lizard", "octopus"]
creatures = {kind: make_creature(kind, seed=1, vertex_count=1_500) for kind in kinds}

# %%
# The query is the horse in full gallop, 2.5 times as large, and with fewer vertices.

other = make_creature("horse", seed=1, vertex_count=1_200).pose("gallop")
query = sg.Mesh(2.5 * other.vertices, other.faces, "unknown")

# %%
# These are the five lines:

folder = tempfile.TemporaryDirectory()
with sg.Library.open(Path(folder.name, "animals.sglib")) as library:
    for kind, creature in creatures.items():
        library.add(creature.rest, name=kind)
    matches = library.query(query, top=4)

# %%
# A match has a *similarity*, the confidence that it is the same shape, and *evidence*: how the two
# surfaces are related, and by which factor they differ in size. Behind the same shape come others of its
# kind.

for match in matches:
    print(f"{match.similarity:.2f}  {match.name:8}  {match.evidence.kind}, size ×{match.evidence.factor:.2f}")

captions = ["query"] + [f"{match.name}: {match.similarity:.2f}\n{match.evidence.kind}" for match in matches]
show_shapes([query] + [creatures[match.name].rest for match in matches], captions, columns=5)
folder.cleanup()
