# SPDX-License-Identifier: GPL-3.0-or-later
"""Packages that the add-on needs, and what is shown in its place where one of them is not there."""

from __future__ import annotations

import importlib.util
import sys
from typing import Any

import bpy

from .sidebar import SidebarPanel
from .translation import tr
from .wrapped_text import split_lines

__all__ = ["draw_sentence", "register", "sentence", "unregister"]

# numpy comes with Blender, though not with the builds of all distributions; the others with the extension.
BUNDLED = (
    *("scipy", "sklearn", "joblib", "threadpoolctl", "robust_laplacian", "fast_simplification", "trimesh"),
    *("mapbox_earcut", "onnxruntime", "PIL", "pebble", "tqdm", "psycopg", "psycopg_binary"),
    *("typing_extensions", "shapegoogle_core"),
)


def sentence() -> str:
    """Say which package is missing and what to do about it, without importing any.

    A zip for another Python does not get this far: Blender refuses to switch it on, and names both Pythons.

    Returns
    -------
    sentence : str
        Empty if all are there.
    """
    major, minor = sys.version_info[:2]
    if importlib.util.find_spec("numpy") is None:
        return tr(
            "Shape Google needs numpy, which this Blender does not have: use a Blender from blender.org, or "
            "install numpy for its Python {python} (on Debian and Ubuntu the package python3-numpy), and "
            "start Blender again"
        ).format(python=f"{major}.{minor}")
    missing = [name for name in BUNDLED if importlib.util.find_spec(name) is None]
    if missing:
        return tr(
            "Shape Google cannot find {packages}, which its zip contains: install the zip whose name ends in "
            "{ending} again, and start Blender again"
        ).format(packages=", ".join(missing), ending=f"cp{major}{minor}.zip")
    return ""


def draw_sentence(layout: Any, text: str, letters: int, icon: str = "ERROR") -> None:
    """Lay a sentence out in as many lines as it takes.

    Parameters
    ----------
    layout : bpy.types.UILayout
    text : str
    letters : int
        Longest line.
    icon : str, optional
        Before the first line.
    """
    column = layout.column(align=True)
    for number, line in enumerate(split_lines(text, letters)):
        column.label(text=line, translate=False, icon="BLANK1" if number and icon != "NONE" else icon)


class SHAPEGOOGLE_PT_needs(SidebarPanel, bpy.types.Panel):
    """What is missing; registered in place of all other panels."""

    bl_label = "Shape Google"

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        width = context.region.width / context.preferences.system.ui_scale
        draw_sentence(self.layout, sentence(), max(20, int(width / 7) - 12))


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PT_needs,))
