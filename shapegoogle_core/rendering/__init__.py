# SPDX-License-Identifier: MIT
"""Pictures of meshes without a graphics card or a window: thumbnails, previews, colours, views."""

from shapegoogle_core.rendering.colors import value_colors, word_palette
from shapegoogle_core.rendering.preview import Preview, make_preview, preview_of_points, read_preview
from shapegoogle_core.rendering.raster import render, thumbnail
from shapegoogle_core.rendering.views import canonical_view, look_from

__all__ = [
    "Preview",
    "canonical_view",
    "look_from",
    "make_preview",
    "preview_of_points",
    "read_preview",
    "render",
    "thumbnail",
    "value_colors",
    "word_palette",
]
