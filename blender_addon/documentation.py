# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that opens the documentation: the manual that the zip contains."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from .translation import tr

__all__ = ["manual", "register", "unregister"]


def manual() -> Path | None:
    """Return the page of the manual; None where the add-on is no built extension and no repository."""
    here = Path(__file__).resolve().parent
    pages = (here / "manual" / "index.html", here.parent / "docs" / "blender" / "index.md")
    return next((page for page in pages if page.is_file()), None)


class SHAPEGOOGLE_OT_open_manual(bpy.types.Operator):
    """Open the documentation."""

    bl_idname = "shape_google.open_manual"
    bl_label = "Open Manual"
    bl_description = (
        "Show the manual of Shape Google, which comes with it, in the web browser; needs no network"
    )

    @classmethod
    def poll(cls, _context: Any) -> bool:
        """Check that the manual is there."""
        if manual() is None:
            cls.poll_message_set(tr("The manual is missing; install the zip of Shape Google again"))
            return False
        return True

    def execute(self, _context: Any) -> set[str]:
        """Open it."""
        page = manual()
        if page is None:
            return {"CANCELLED"}
        bpy.ops.wm.url_open(url=page.as_uri())
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_OT_open_manual,))
