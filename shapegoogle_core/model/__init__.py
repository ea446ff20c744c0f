# SPDX-License-Identifier: MIT
"""The trained model: its settings, its file, and how it describes a shape."""

from shapegoogle_core.model.loading import load_model
from shapegoogle_core.model.metric import row_distances
from shapegoogle_core.model.presets import PRESETS
from shapegoogle_core.model.settings import ChannelSettings, ModelSettings
from shapegoogle_core.model.shape_model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = [
    "PRESETS",
    "ChannelSettings",
    "ModelSettings",
    "ShapeModel",
    "ShapeSignature",
    "load_model",
    "row_distances",
]
