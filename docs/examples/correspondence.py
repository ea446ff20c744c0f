# SPDX-License-Identifier: MIT
"""
Dense correspondence
====================

``sg.match_vertices`` maps every vertex of one shape to a point of another, here of one horse in two poses
with two different meshes. Colours, weights or any other values can then be carried over; *Transfer* in
Blender does so.
"""

import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.figures.shape_rows import show_shapes

target = make_creature("horse", seed=9, vertex_count=2_000).pose("gallop")
source = make_creature("horse", seed=9, vertex_count=1_500).rest

match = sg.match_vertices(target, source)
print(f"mean confidence {match.confidence.mean():.2f}, distortion {match.distortion:.3f}")

# %%
# Colour the source by position, and carry the colours to the target with the barycentric coordinates of
# the map.

low, high = source.vertices.min(axis=0), source.vertices.max(axis=0)
colors = (source.vertices - low) / (high - low)
carried = (match.weights[..., None] * colors[source.faces[match.face]]).sum(axis=1)
show_shapes(
    [source, target], ["source", "target, coloured through the map"], [colors, np.clip(carried, 0, 1)]
)
