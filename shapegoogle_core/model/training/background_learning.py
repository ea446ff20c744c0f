# SPDX-License-Identifier: MIT
"""Learning a `Background`: how much plain shapes' distances are raised is fitted on known pairs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.background import Background
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.model.shape_model import ShapeModel

__all__ = ["FEWEST_SHAPES", "KnownPairs", "learn_background"]

FEWEST_SHAPES = 30
"""Number of different shapes that a background needs."""

# Share of distinctive shapes that count in full.
_DISTINCTIVE = 0.75
_EXPONENTS = np.arange(0, 4.01, 0.25)
# A distance that verification has lowered to 0 would be infinitely certain.
_LEAST_DISTANCE = 1e-6
_LEAST_PROBABILITY = 1e-9


@dataclass(frozen=True, eq=False)
class KnownPairs:
    """Pairs of shapes of which it is known whether they are one shape.

    Attributes
    ----------
    first, second : (m, p) arrays
        Vectors of the shapes, from `ShapeModel.comparable`.
    distances, verified : (m,) arrays
        Distances of their bags, and verified ones.
    same : (m,) array of bool
        Whether both are versions of one shape.
    """

    first: FloatBags
    second: FloatBags
    distances: FloatArray
    verified: FloatArray
    same: NDArray[np.bool_]


def learn_background(
    model: ShapeModel, vectors: FloatBags, distinctive: FloatBags, pairs: KnownPairs
) -> Background:
    """Make a background and fit its numbers.

    Parameters
    ----------
    model : ShapeModel
        With its calibration.
    vectors : (n, p) array
        Unlike shapes, see `Background.vectors`.
    distinctive : (k, p) array
        Shapes that resemble nothing else; three quarters of them count in full.
    pairs : KnownPairs
        The exponents are chosen under which the similarities of these are most likely, with equal weight for
        pairs of one shape and of two.

    Returns
    -------
    background : Background
    """
    metric = model.settings.metric
    background = Background(vectors.astype(np.float16), distinctive=1.0, exponent=0.0, verified_exponent=0.0)
    threshold = float(np.quantile(background.distances(metric, distinctive), 1 - _DISTINCTIVE))
    background = replace(background, distinctive=round(threshold, 3))
    typical = np.sqrt(background.distances(metric, pairs.first) * background.distances(metric, pairs.second))
    exponents = []
    for verified in (False, True):
        distances = np.maximum(pairs.verified if verified else pairs.distances, _LEAST_DISTANCE)
        losses = []
        for exponent in _EXPONENTS.tolist():
            tried = replace(background, exponent=exponent, verified_exponent=exponent)
            similarities = replace(model, background=tried).similarity(distances, typical, verified=verified)
            right = np.maximum(np.where(pairs.same, similarities, 1 - similarities), _LEAST_PROBABILITY)
            losses.append(-np.log(right[pairs.same]).mean() - np.log(right[~pairs.same]).mean())
        exponents.append(float(_EXPONENTS[np.argmin(losses)]))
    return replace(background, exponent=exponents[0], verified_exponent=exponents[1])
