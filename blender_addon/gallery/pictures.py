# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the matches, as Blender's icons."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import bpy.utils.previews

from .. import state
from ..state.parts import GalleryView

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["clear", "icon_of", "keep", "pixels_of"]


def keep(shape_id: int, png: bytes | None) -> None:
    """Make the icon of a shape.

    Parameters
    ----------
    shape_id : int
    png : bytes or None
        Without a picture the shape has no icon.
    """
    gallery = state.current().gallery
    if png is None or (gallery.pictures is not None and str(shape_id) in gallery.pictures):
        return
    pixels = pixels_of(png)
    if pixels is None:
        return
    if gallery.pictures is None:
        gallery.pictures = bpy.utils.previews.new()
    preview = gallery.pictures.new(str(shape_id))
    preview.image_size = pixels.shape[1], pixels.shape[0]
    preview.image_pixels_float.foreach_set(pixels.ravel())


def pixels_of(png: bytes) -> NDArray[np.float32] | None:
    """Read a picture as Blender has pictures: rows from below, values from 0 to 1.

    Parameters
    ----------
    png : bytes

    Returns
    -------
    pixels : (height, width, 4) array or None
        None if the content is damaged: a shape without a picture can still be used.
    """
    import io

    import numpy as np
    from PIL import Image

    try:
        with Image.open(io.BytesIO(png)) as image:
            return np.asarray(image.convert("RGBA"), np.float32)[::-1] / np.float32(255)
    # What Pillow raises for a damaged file.
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        return None


def icon_of(shape_id: int) -> int:
    """Return the number of a shape's icon; that of a question mark if it has no picture."""
    pictures = state.current().gallery.pictures
    preview = None if pictures is None else pictures.get(str(shape_id))
    if preview is not None:
        return int(preview.icon_id)
    icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
    return int(icons["QUESTION"].value)


def clear() -> None:
    """Remove the icons of all shapes."""
    gallery = state.current().gallery
    gallery.view = GalleryView()
    if gallery.pictures is not None:
        bpy.utils.previews.remove(gallery.pictures)
        gallery.pictures = None
