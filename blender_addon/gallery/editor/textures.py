# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of shapes on the graphics card: only those that were seen, the oldest dropped first."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gpu

from ... import state
from ..pictures import pixels_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["clear", "drop_oldest", "is_made", "texture_of"]

# At 256 × 256 pixels these take 64 MB.
_MOST = 256


def texture_of(shape_id: int, *, make: bool = True) -> Any | None:
    """Return the picture of a shape.

    Parameters
    ----------
    shape_id : int
    make : bool
        Whether to make it if it is not there yet, which takes about a millisecond.

    Returns
    -------
    texture : gpu.types.GPUTexture or None
        None without a picture.
    """
    textures = state.current().gallery.view.textures
    if shape_id in textures:
        textures.move_to_end(shape_id)
        return textures[shape_id]
    if not make:
        return None
    png = _png(shape_id)
    pixels = None if png is None else pixels_of(png)
    textures[shape_id] = None if pixels is None else _texture(pixels)
    return textures[shape_id]


def drop_oldest(shown: int) -> None:
    """Drop the pictures that were seen longest ago, but none of those on the screen.

    Parameters
    ----------
    shown : int
        Number of shapes on the screen, which were asked for last.
    """
    textures = state.current().gallery.view.textures
    while len(textures) > max(_MOST, shown):
        textures.popitem(last=False)


def is_made(shape_id: int) -> bool:
    """Whether the picture of a shape is on the graphics card, or there is none."""
    return shape_id in state.current().gallery.view.textures


def clear() -> None:
    """Drop all pictures."""
    state.current().gallery.view.textures.clear()


def _png(shape_id: int) -> bytes | None:
    search = state.current().search
    for answer in (search.versions, search.answer):
        if answer is not None and shape_id in answer.thumbnails:
            return answer.thumbnails[shape_id]
    return None


def _texture(pixels: NDArray[np.float32]) -> Any:
    # Transparent pixels have no colour, which smoothing would mix in: multiply it in, for linear values.
    pixels = pixels.copy()
    pixels[..., :3] *= pixels[..., 3:] ** (1 / 2.2)
    height, width = pixels.shape[:2]
    content = gpu.types.Buffer("FLOAT", pixels.size, pixels.ravel())
    # The region of an editor of nodes encodes what shaders write as sRGB, so they must read linear values.
    return gpu.types.GPUTexture((width, height), format="SRGB8_A8", data=content)
