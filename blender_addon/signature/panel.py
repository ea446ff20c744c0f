# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Signature: heat kernel signatures and words on the selected objects.

All rows are always there, with the same heights: nothing moves under the pointer.
"""

from __future__ import annotations

from typing import Any, ClassVar

import bpy

from ..library.present import follow
from ..sidebar import SidebarPanel
from ..translation import tr
from . import bag_chart, distance
from .picked import picked_text
from .properties import settings_of

__all__ = ["register", "unregister"]

# Settings of each kind, one a row.
_ROWS = {
    "HKS": ("scale",),
    "HEAT": ("scale",),
    "HKS_TIMES": ("count", "shown"),
    "SI_HKS": ("frequencies", "shown"),
    "WORDS": ("channel", "weights"),
    "KEYPOINTS": ("detector",),
}
MOST_ROWS = max(map(len, _ROWS.values()))
# The chart of a bag is as wide as the sidebar lets it be, in units of the interface of 20 pixels.
UNIT = 20.0
CHART_MARGIN = 4.0
LARGEST_CHART = 14.0


class SHAPEGOOGLE_PT_signature(SidebarPanel, bpy.types.Panel):
    """Paint signatures and words, and look at the bag of the active object."""

    bl_label = "Signature"
    bl_order = 30

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        follow(context)
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.shape_google_painting
        layout.prop(settings, "kind", text="")
        item = context.active_object
        # As many rows for every kind, so that the buttons below keep their places.
        column = layout.column()
        names = _ROWS.get(settings.kind, ())
        for name in names:
            column.prop(settings, name, slider=name == "scale")
        for _ in range(MOST_ROWS - len(names)):
            column.label(text="")
        column.label(**_note(settings.kind, item, context))
        layout.prop(settings, "color")
        layout.prop(settings, "keep")
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.operator("shape_google.paint", icon="BRUSH_DATA")
        row.operator("shape_google.clear_paint", icon="X")
        layout.operator("shape_google.select_keypoints", icon="VERTEXSEL")


def _note(kind: str, item: Any, context: Any) -> dict[str, str]:
    """Text and icon of the line below the settings of a kind."""
    if kind == "HEAT":
        return {"text": picked_text(item), "icon": "VERTEXSEL"}
    if kind != "HKS":
        return {"text": ""}
    chosen = settings_of(context.scene)
    text = "" if item is None else distance.scale_text(item, chosen, context.scene.unit_settings)
    return {"text": text or tr("Paint to see how far it spreads"), "icon": "DRIVER_DISTANCE"}


class SHAPEGOOGLE_PT_signature_bag(SidebarPanel, bpy.types.Panel):
    """The bag of words of the active object."""

    bl_label = "Bag of Words"
    bl_parent_id = "SHAPEGOOGLE_PT_signature"
    bl_options: ClassVar = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        """Lay the panel out, as high without a chart as with one."""
        layout = self.layout
        item = context.active_object
        # The chart outlives the words on the object, which may be cleared or undone.
        painted = item is not None and item.type == "MESH" and "sg_word" in item.data.attributes
        icon = bag_chart.icon_of(item) if painted else 0
        text = (
            tr("Bag of {name}").format(name=item.name) if icon else tr("Paint Geometric Words to see the bag")
        )
        layout.label(text=text, translate=False)
        units = context.region.width / (UNIT * context.preferences.system.ui_scale)
        layout.template_icon(icon, scale=min(max(units - CHART_MARGIN, 1.0), LARGEST_CHART))


class SHAPEGOOGLE_PT_signature_computation(SidebarPanel, bpy.types.Panel):
    """How spectra are computed."""

    bl_label = "Computation"
    bl_parent_id = "SHAPEGOOGLE_PT_signature"
    bl_options: ClassVar = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.shape_google_painting
        layout.active = settings.kind != "WORDS"  # computed as their model says
        layout.prop(settings, "eigenpairs")
        layout.prop(settings, "laplacian")
        layout.prop(settings, "budget")


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_PT_signature, SHAPEGOOGLE_PT_signature_bag, SHAPEGOOGLE_PT_signature_computation)
)
