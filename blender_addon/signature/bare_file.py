# SPDX-License-Identifier: GPL-3.0-or-later
"""`BareFile`: a file that is opened without having Blender compute modifiers, and saved with them.

What is painted are meshes before modifiers, and where an object stands and how large it is does not depend on
its own. A file whose objects are subdivided, or scattered by nodes, can need more memory than there is.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.app.handlers import persistent

__all__ = ["BareFile"]


class BareFile:
    """Opens a file with its modifiers switched off, before Blender computes what its window shows.

    Parameters
    ----------
    path : Path

    Raises
    ------
    RuntimeError
        If Blender cannot open it.
    """

    def __init__(self, path: Path) -> None:
        self._modifiers: list[Any] = []

        @persistent
        def switch_off(*_arguments: object) -> None:
            self._modifiers = [
                modifier for item in bpy.data.objects for modifier in item.modifiers if modifier.show_viewport
            ]
            self._show(False)

        handlers = bpy.app.handlers.load_post
        # First: another handler may have Blender compute the scene.
        handlers.insert(0, switch_off)
        try:
            bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=True, use_scripts=False)
        finally:
            handlers.remove(switch_off)

    def save(self, path: Path) -> None:
        """Save a copy, with the modifiers as they were.

        Parameters
        ----------
        path : Path

        Raises
        ------
        RuntimeError
            If Blender cannot write it.
        """

        def switch_on(*_arguments: object) -> None:
            self._show(True)

        def switch_off(*_arguments: object) -> None:
            self._show(False)

        # Blender computes what has changed before and after an operator, so they are on only while it writes.
        before = bpy.app.handlers.save_pre
        after = (bpy.app.handlers.save_post, bpy.app.handlers.save_post_fail)
        before.append(switch_on)
        for handlers in after:
            handlers.append(switch_off)
        try:
            bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, check_existing=False)
        finally:
            before.remove(switch_on)
            for handlers in after:
                handlers.remove(switch_off)

    def _show(self, shown: bool) -> None:
        for modifier in self._modifiers:
            modifier.show_viewport = shown
