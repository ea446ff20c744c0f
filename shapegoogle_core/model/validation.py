# SPDX-License-Identifier: MIT
"""Consistency of what a model has learnt with its settings: a damaged file must not give wrong answers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shapegoogle_core.errors import ModelError

if TYPE_CHECKING:
    from shapegoogle_core.model.shape_model import ShapeModel

__all__ = ["check_learnt"]


def check_learnt(model: ShapeModel) -> None:
    """Raise unless all that a model has learnt has the sizes that its settings ask for.

    Parameters
    ----------
    model : ShapeModel

    Raises
    ------
    ModelError
        If an array has another shape or is not finite, or a number is out of range.
    """
    size, projected, bits = model.bag_size, model.projection.shape[-1], model.code_bits
    expected = {
        "weights": (size,),
        "mean": (size,),
        "projection": (size, projected),
        "directions": (bits, projected),
        "thresholds": (bits,),
    }
    for name, shape in expected.items():
        array = getattr(model, name)
        if array.shape != shape or not np.isfinite(array).all():
            raise ModelError(f"the model's {name} are damaged: expected finite numbers of shape {shape}")
    for channel, words in zip(model.settings.channels, model.vocabularies, strict=True):
        fits = words.centers.shape == (channel.words, channel.size)
        if not (fits and np.isfinite(words.centers).all() and 0 < words.sigma < np.inf):
            raise ModelError(f"the model's vocabulary of {channel.descriptor!r} is damaged")
    calibration = (
        model.similarity_half,
        model.similarity_slope,
        model.verified_half,
        model.verified_slope,
    )
    if not all(0 < value < np.inf for value in calibration):
        raise ModelError("the model's calibration of similarities is damaged")
    if not 0 <= model.agreement_gain < np.inf:
        raise ModelError("the model's agreement_gain is damaged: it must be a number ≥ 0")
    local = None if model.settings.local is None else model.settings.local.words
    if local != (None if model.local_words is None else len(model.local_words.weights)):
        raise ModelError("the model's local words are damaged: they are not of the size in its settings")
