# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of the gallery, which Blender's preferences list and change like all others.

The editor of nodes and the scrolling of areas have keys of their own; those of add-ons come first, and go on
to Blender's own where the pointer is not in a gallery.
"""

from __future__ import annotations

from typing import Any

import bpy

__all__ = ["register", "unregister"]

_PREFIX = "shape_google.gallery_"
_EDITOR, _SCROLLING = ("Node Editor", "NODE_EDITOR"), ("View2D", "EMPTY")
# Keymap, operator, type and value of the event, modifiers, properties.
_KEYS: tuple[tuple[tuple[str, str], str, str, str, dict[str, bool], dict[str, str]], ...] = (
    (_EDITOR, "press", "LEFTMOUSE", "PRESS", {}, {}),
    (_EDITOR, "press", "LEFTMOUSE", "DOUBLE_CLICK", {}, {}),
    (_EDITOR, "menu", "RIGHTMOUSE", "PRESS", {}, {}),
    (_EDITOR, "hover", "MOUSEMOVE", "ANY", {"any": True}, {}),
    (_EDITOR, "compare", "C", "PRESS", {}, {}),
    (_EDITOR, "search", "F", "PRESS", {"ctrl": True}, {}),
    (_EDITOR, "search", "SLASH", "PRESS", {}, {}),
    *(
        (_EDITOR, "key", key, "PRESS", {}, {})
        for key in (
            *("LEFT_ARROW", "RIGHT_ARROW", "UP_ARROW", "DOWN_ARROW", "PAGE_UP", "PAGE_DOWN", "HOME", "END"),
            *("RET", "NUMPAD_ENTER", "NUMPAD_PLUS", "NUMPAD_MINUS", "EQUAL", "MINUS", "ESC"),
        )
    ),
    (_SCROLLING, "turn", "MIDDLEMOUSE", "PRESS", {}, {}),
    (_SCROLLING, "scroll", "WHEELUPMOUSE", "PRESS", {}, {"step": "UP"}),
    (_SCROLLING, "scroll", "WHEELDOWNMOUSE", "PRESS", {}, {"step": "DOWN"}),
    (_SCROLLING, "scroll", "WHEELUPMOUSE", "PRESS", {"ctrl": True}, {"step": "LARGER"}),
    (_SCROLLING, "scroll", "WHEELDOWNMOUSE", "PRESS", {"ctrl": True}, {"step": "SMALLER"}),
    (_SCROLLING, "scroll", "TRACKPADPAN", "ANY", {}, {"step": "PAN"}),
)


def register() -> None:
    """Add the keys; in the background there are none."""
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:
        return
    for (name, space), operator, key, value, modifiers, properties in _KEYS:
        keymap = configuration.keymaps.new(name=name, space_type=space)
        item = keymap.keymap_items.new(_PREFIX + operator, key, value, **modifiers)
        for entry, setting in properties.items():
            setattr(item.properties, entry, setting)


def unregister() -> None:
    """Remove them."""
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:
        return
    for name, _space in (_EDITOR, _SCROLLING):
        keymap: Any = configuration.keymaps.get(name)
        if keymap is None:
            continue
        for item in list(keymap.keymap_items):
            if item.idname.startswith(_PREFIX):
                keymap.keymap_items.remove(item)
