# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Signature: heat kernel signatures and words on the selected objects."""

from __future__ import annotations

from typing import Any, ClassVar

import bpy

from ..library.warm_up import warm_up
from . import bag_chart, distance
from .choices import TIMED
from .properties import settings_of

__all__ = ["register", "unregister"]

# The chart of a bag is as wide as the sidebar lets it be, in units of the interface of 20 pixels.
UNIT = 20.0
CHART_MARGIN = 4.0
LARGEST_CHART = 14.0


class SHAPEGOOGLE_PT_signature(bpy.types.Panel):
    """Paint signatures and words, and look at the bag of the active object."""

    bl_label = "Signature"
    bl_category = "Shape Google"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_order = 30

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        warm_up(context)
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.shape_google_painting
        layout.prop(settings, "kind", text="")
        item = context.active_object
        column = layout.column()
        if settings.kind in TIMED:
            column.prop(settings, "scale", slider=True)
            text = (
                ""
                if item is None
                else distance.scale_text(item, settings_of(context.scene), context.scene.unit_settings)
            )
            column.label(text=text or "Paint to see how far it spreads", icon="DRIVER_DISTANCE")
            if settings.kind == "HEAT":
                column.label(text="From the selected vertex", icon="VERTEXSEL")
        elif settings.kind == "HKS_TIMES":
            column.prop(settings, "count")
            column.prop(settings, "shown")
        elif settings.kind == "SI_HKS":
            column.prop(settings, "frequencies")
            column.prop(settings, "shown")
        elif settings.kind == "WORDS":
            column.prop(settings, "channel")
            column.prop(settings, "weights")
        elif settings.kind == "KEYPOINTS":
            column.prop(settings, "detector")
        layout.prop(settings, "color")
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.operator("shape_google.paint", icon="BRUSH_DATA")
        row.operator("shape_google.clear_paint", icon="X")
        if settings.kind == "KEYPOINTS":
            layout.operator("shape_google.select_keypoints", icon="VERTEXSEL")
        icon = 0 if item is None else bag_chart.icon_of(item)
        if settings.kind == "WORDS" and icon:
            layout.label(text=f"Bag of {item.name}")
            units = context.region.width / (UNIT * context.preferences.system.ui_scale)
            layout.template_icon(icon, scale=min(max(units - CHART_MARGIN, 1.0), LARGEST_CHART))


class SHAPEGOOGLE_PT_signature_computation(bpy.types.Panel):
    """How spectra are computed."""

    bl_label = "Computation"
    bl_category = "Shape Google"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_parent_id = "SHAPEGOOGLE_PT_signature"
    bl_options: ClassVar = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Words are computed as their model says."""
        return bool(context.scene.shape_google_painting.kind != "WORDS")

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.shape_google_painting
        layout.prop(settings, "eigenpairs")
        layout.prop(settings, "laplacian")
        layout.prop(settings, "budget")


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_PT_signature, SHAPEGOOGLE_PT_signature_computation)
)
