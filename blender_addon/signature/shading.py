# SPDX-License-Identifier: GPL-3.0-or-later
"""The shading of 3D views while painted colours are shown, and what it was before.

Undo does not reach the shading of a view. So each screen keeps what its views had before the first painting,
in a custom property, which goes when it is restored: when the colours are cleared, or undo removes them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from .. import state
from .choices import COLOR

__all__ = ["follow_undo", "restore_unpainted", "show_colors"]

# Custom property of a screen: shading by the number of the area, in text.
KEPT = "shape_google_shading"
SHOWN = "SOLID", "VERTEX"


def show_colors(context: Any) -> None:
    """Let the 3D view in which the button was pressed show attribute colours.

    Parameters
    ----------
    context : bpy.types.Context
    """
    space = context.space_data
    if space is None or space.type != "VIEW_3D":
        return
    screen = context.screen
    number = next(place for place, area in enumerate(screen.areas) if area == context.area)
    state.current().signature.restored_views = []
    _show(screen, number)


def restore_unpainted(context: Any) -> None:
    """Restore the shading of all views, if no object of the scene has painted colours any more.

    Parameters
    ----------
    context : bpy.types.Context
    """
    if not _is_painted(context.scene):
        _restore_all(list(_kept()))


def follow_undo(context: Any) -> None:
    """Let the shading of all views follow undo and redo of painting and of clearing.

    Parameters
    ----------
    context : bpy.types.Context
    """
    signature = state.current().signature
    kept = list(_kept())
    if not (kept or signature.restored_views) or _is_painted(context.scene) == bool(kept):
        return
    if kept:
        _restore_all(kept)
        return
    for name, number in signature.restored_views:
        screen = bpy.data.screens.get(name)
        if screen is not None and _view(screen, number) is not None:
            _show(screen, number)
    signature.restored_views = []


def _restore_all(kept: list[tuple[Any, int, tuple[str, str]]]) -> None:
    state.current().signature.restored_views = [
        (screen.name, number) for screen, number, before in kept if _restore(screen, number, before)
    ]


def _kept() -> Iterator[tuple[Any, int, tuple[str, str]]]:
    """Screen, number of the area and earlier shading of each view that shows our colours."""
    for screen in bpy.data.screens:
        for number, (kind, color) in dict(screen.get(KEPT, {})).items():
            yield screen, int(number), (kind, color)


def _is_painted(scene: Any) -> bool:
    return any(item.type == "MESH" and COLOR in item.data.attributes for item in scene.objects)


def _view(screen: Any, number: int) -> Any | None:
    """Shading of a 3D view; None where the areas were rearranged and there is none."""
    areas = screen.areas
    is_view = number < len(areas) and areas[number].type == "VIEW_3D"
    return areas[number].spaces.active.shading if is_view else None


def _show(screen: Any, number: int) -> None:
    shading = _view(screen, number)
    if shading is None or (shading.type, shading.color_type) == SHOWN:
        return
    screen[KEPT] = {**dict(screen.get(KEPT, {})), str(number): [shading.type, shading.color_type]}
    shading.type, shading.color_type = SHOWN
    screen.areas[number].tag_redraw()


def _restore(screen: Any, number: int, before: tuple[str, str]) -> bool:
    """Restore a view, unless the user has chosen another shading since; whether it was restored."""
    kept = dict(screen[KEPT])
    del kept[str(number)]
    if kept:
        screen[KEPT] = kept
    else:
        del screen[KEPT]
    shading = _view(screen, number)
    if shading is None or (shading.type, shading.color_type) != SHOWN:
        return False
    shading.color_type = before[1]
    shading.type = before[0]
    screen.areas[number].tag_redraw()
    return True
