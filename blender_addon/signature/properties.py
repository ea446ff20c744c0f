# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel Signature is set to: on the scene, so that it is saved and undo brings it back."""

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from .choices import CHANNELS, DETECTORS, KINDS, LAPLACIANS, Painting

__all__ = ["register", "settings_of", "unregister"]


def _repaint(_settings: Any, context: Any) -> None:
    from . import painting

    painting.repaint(context, settings_of(context.scene), context.scene.shape_google_painting.color)


class SHAPEGOOGLE_PG_painting(bpy.types.PropertyGroup):
    """Settings of painting; what can be shown at once is repainted when they change."""

    kind: EnumProperty(name="Attribute", description="What to write onto the vertices", items=KINDS)
    scale: FloatProperty(
        name="Time",
        description=(
            "How long heat spreads: 0 shows the smallest parts, 1 the whole shape. "
            "Selected objects that were painted are repainted while you drag"
        ),
        default=0.5,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_repaint,
    )
    count: IntProperty(
        name="Times", description="How many times, from the shortest to the longest", default=6, min=2, max=32
    )
    frequencies: IntProperty(
        name="Frequencies", description="How many of the lowest frequencies", default=6, min=1, max=32
    )
    shown: IntProperty(
        name="Shown",
        description="Which of the values the color shows, from 1",
        default=1,
        min=1,
        max=32,
        update=_repaint,
    )
    channel: EnumProperty(name="Words of", description="Which of the model's vocabularies", items=CHANNELS)
    weights: IntProperty(
        name="Soft Weights",
        description=(
            "For how many words, the most frequent of the object, the soft weights are written too: "
            "an attribute sg_weight_<word> each"
        ),
        default=4,
        min=0,
        max=512,
    )
    detector: EnumProperty(name="Detector", description="What finds the keypoints", items=DETECTORS)
    color: BoolProperty(
        name="Color", description="Also write the color attribute sg_color and show it", default=True
    )
    eigenpairs: IntProperty(
        name="Eigenpairs",
        description="How many eigenfunctions of the Laplacian: more show smaller parts and take longer",
        default=100,
        min=10,
        max=500,
    )
    laplacian: EnumProperty(
        name="Laplacian", description="How the Laplace–Beltrami operator is discretised", items=LAPLACIANS
    )
    budget: IntProperty(
        name="Simplify Above",
        description=(
            "Of an object with more vertices, the signature is computed on a copy simplified to this many "
            "and carried back to all of them: seconds instead of minutes. Others are computed as they are"
        ),
        default=20_000,
        min=1_000,
        max=1_000_000,
    )


def settings_of(scene: Any) -> Painting:
    """Read what a scene's settings ask for.

    Parameters
    ----------
    scene : bpy.types.Scene

    Returns
    -------
    painting : Painting
    """
    chosen = scene.shape_google_painting
    return Painting(
        kind=chosen.kind,
        scale=chosen.scale,
        count=chosen.count,
        frequencies=chosen.frequencies,
        shown=chosen.shown,
        channel=chosen.channel,
        weights=chosen.weights,
        detector=chosen.detector,
        eigenpairs=chosen.eigenpairs,
        laplacian=chosen.laplacian,
        budget=chosen.budget,
    )


_register, _unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_painting,))


def register() -> None:
    """Make the settings known to Blender."""
    _register()
    bpy.types.Scene.shape_google_painting = PointerProperty(type=SHAPEGOOGLE_PG_painting)


def unregister() -> None:
    """Take them back; what files hold of them stays in them."""
    del bpy.types.Scene.shape_google_painting
    _unregister()
