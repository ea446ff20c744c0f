# SPDX-License-Identifier: MIT
"""Pictures of meshes without a graphics card or a window: thumbnails, colours, views."""

from shapegoogle_core.rendering.colors import value_colors, word_palette
from shapegoogle_core.rendering.raster import render, thumbnail
from shapegoogle_core.rendering.views import canonical_view, look_from

__all__ = ["canonical_view", "look_from", "render", "thumbnail", "value_colors", "word_palette"]
