# SPDX-License-Identifier: MIT
"""Points in three clusters, for learning words from."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray


def blobs(seed: int = 0, outliers: int = 0) -> FloatArray:
    random = np.random.default_rng(seed)
    points = [center + 0.1 * random.standard_normal((200, 2)) for center in ([0, 0], [5, 0], [0, 5])]
    return np.concatenate([*points, random.uniform(50, 100, (outliers, 2))])
