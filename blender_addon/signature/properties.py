# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the panel Signature, kept on the scene so that they are saved and undone with it."""

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from .choices import CHANNELS, DETECTORS, KINDS, LAPLACIANS, Painting

__all__ = ["register", "settings_of", "unregister"]


def _repaint(_settings: Any, context: Any) -> None:
    from . import painting

    painting.repaint(context, settings_of(context.scene), context.scene.shape_google_painting.color)


class SHAPEGOOGLE_PG_painting(bpy.types.PropertyGroup):
    """Settings of painting; some repaint at once when they change."""

    kind: EnumProperty(name="Attribute", description="Attribute to write onto the vertices", items=KINDS)
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
        name="Times",
        description="Number of times, from the shortest to the longest",
        default=6,
        min=2,
        max=32,
    )
    frequencies: IntProperty(
        name="Frequencies", description="Number of frequencies, from the lowest", default=6, min=1, max=32
    )
    shown: IntProperty(
        name="Shown",
        description="Number of the value that the color shows, from 1",
        default=1,
        min=1,
        max=32,
        update=_repaint,
    )
    channel: EnumProperty(name="Words of", description="Vocabulary of the model", items=CHANNELS)
    weights: IntProperty(
        name="Soft Weights",
        description=(
            "Number of words, the most frequent of the object, whose soft weights are written too, as "
            "attributes sg_weight_<word>"
        ),
        default=4,
        min=0,
        max=512,
    )
    detector: EnumProperty(name="Detector", description="Method that finds the keypoints", items=DETECTORS)
    color: BoolProperty(
        name="Color", description="Also write the color attribute sg_color and show it", default=True
    )
    keep: BoolProperty(
        name="Keep Others",
        description="Keep what was painted of other kinds; else painting removes it",
        default=False,
    )
    eigenpairs: IntProperty(
        name="Eigenpairs",
        description="Number of eigenfunctions of the Laplacian: more show smaller parts and take longer",
        default=100,
        min=10,
        max=500,
    )
    laplacian: EnumProperty(
        name="Laplacian", description="Discretisation of the Laplace–Beltrami operator", items=LAPLACIANS
    )
    budget: IntProperty(
        name="Simplify Above",
        description=(
            "An object with more vertices is simplified to this many, and its signature is carried back to "
            "all vertices: seconds instead of minutes"
        ),
        default=20_000,
        min=1_000,
        max=1_000_000,
    )


def settings_of(scene: Any) -> Painting:
    """Read the settings of a scene.

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
    """Register the settings."""
    _register()
    bpy.types.Scene.shape_google_painting = PointerProperty(type=SHAPEGOOGLE_PG_painting)


def unregister() -> None:
    """Unregister the settings; files keep their values."""
    del bpy.types.Scene.shape_google_painting
    _unregister()
