# SPDX-License-Identifier: MIT
"""
Painted signatures
==================

What does the search see? This example paints heat kernel signatures, geometric words and keypoints onto a
creature in two poses. In Blender the panel *Signature* does the same.
"""

import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from benchmarks.figures.shape_rows import show_shapes
from shapegoogle_core.rendering import value_colors, word_palette

creature = make_creature("horse", seed=2011, vertex_count=4_000)
poses = [creature.pose("rest"), creature.pose("gallop")]

# %%
# **Heat kernel signature.** The value at a point says how much heat remains there after a time *t*. At
# small times it shows fine details; at large times only the limbs and the trunk differ. Bending hardly
# changes it: both rows look alike.

spectra = [sg.compute_spectrum(pose, k=100) for pose in poses]
times = np.geomspace(0.002, 0.1, 4) * poses[0].area
values = [np.log(sg.heat_kernel_signature(spectrum, times)) for spectrum in spectra]
show_shapes(
    [pose for pose in poses for _ in times],
    [f"t = {time / poses[0].area:.3f} · area" for time in times] * 2,
    [
        value_colors(signature[:, i], *np.quantile(values[0][:, i], [0.02, 0.98]))
        for signature in values
        for i in range(len(times))
    ],
)

# %%
# **Geometric words.** Each vertex is assigned to the words of a vocabulary whose descriptors are near its
# own. A word has the same colour on every shape, and lies on the same part of the body in every pose.

model = sg.load_model()
words = [sg.vertex_words(model, pose) for pose in poses]
palette = word_palette(words[0].words.shape[1])
show_shapes(poses, ["words, at rest", "words, galloping"], [palette[word.heaviest] for word in words])

# %%
# **Keypoints.** The maxima of the heat kernel are the tips of limbs. ``strength`` and ``coverage`` make
# spots of them.

spots = [sg.vertex_keypoints(pose, "hks-maxima") for pose in poses]
colors = []
for found in spots:
    amount = found.prolongation @ np.c_[found.strength, found.coverage]
    red = np.array([0.85, 0.15, 0.1])
    colors.append((1 - amount[:, 1:]) * 0.75 + amount[:, 1:] * red)
show_shapes(poses, [f"{len(found)} keypoints" for found in spots], colors)
