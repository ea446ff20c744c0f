# SPDX-License-Identifier: MIT
from shapegoogle_core.model.loading import load_model as load_model
from shapegoogle_core.model.metric import row_distances as row_distances
from shapegoogle_core.model.presets import PRESETS as PRESETS
from shapegoogle_core.model.settings import ChannelSettings as ChannelSettings
from shapegoogle_core.model.settings import ModelSettings as ModelSettings
from shapegoogle_core.model.shape_model import ShapeModel as ShapeModel
from shapegoogle_core.model.signature import ShapeSignature as ShapeSignature

__all__: list[str]
