# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab of the add-on in the sidebar of the 3D view."""

from __future__ import annotations

__all__ = ["SidebarPanel"]


class SidebarPanel:
    """What all panels of the tab have in common; `bpy.types.Panel` is their other base."""

    bl_category = "Shape Google"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
