# SPDX-License-Identifier: GPL-3.0-or-later
"""Putting a painting onto objects, and what the panel says about it: how far heat has spread on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy

from .. import scene
from . import attributes, bag_chart, spectra
from .painting import Painting, time_range

if TYPE_CHECKING:
    from .spectra import Known

__all__ = ["apply", "clear", "distance_text", "repaint", "scale_text", "targets"]

# Of these kinds the colour follows the time slider.
TIMED = ("HKS", "HEAT")
# Of these it can show one value or another without being computed anew.
SEVERAL = ("HKS_TIMES", "SI_HKS")


@dataclass(frozen=True)
class _Range:
    """Times of an object in squared world units, and its size in world units."""

    shortest: float
    longest: float
    size: float


_ranges: dict[int, _Range] = {}


def targets(objects: Sequence[Any]) -> tuple[list[Any], list[str]]:
    """Objects to paint: meshes that can be changed and whose scale is known, one for each mesh.

    Parameters
    ----------
    objects : sequence of bpy.types.Object
        Of the view layer of the context.

    Returns
    -------
    items : list of bpy.types.Object
    refused : list of str
        A sentence for each mesh object that cannot be painted.
    """
    items, refused, seen = [], [], set()
    meshes = scene.mesh_objects(objects)
    hidden = set(scene.split_evaluated(meshes, bpy.context)[1])
    for item in meshes:
        if item in hidden:
            refused.append(
                f"{item.name!r} is disabled in viewports or in an excluded collection, so that its scale is "
                "not known; show it first"
            )
        elif not item.data.is_editable:
            refused.append(f"{item.name!r} has its mesh in another file; make it local first")
        elif item.data not in seen:
            seen.add(item.data)
            items.append(item)
    return items, refused


def apply(
    item: Any, chosen: Painting, entry: Known, *, color: bool = True, source: int | None = None
) -> None:
    """Write what is known of an object onto its vertices.

    Parameters
    ----------
    item : bpy.types.Object
    chosen : Painting
    entry : Known
    color : bool
        Whether to write the colour attribute.
    source : int, optional
        Vertex that heat spreads from; left out, the one that is selected.

    Raises
    ------
    MeshError
        If the object has no such values.
    """
    from shapegoogle_core import VertexSpectrum, VertexWords

    attributes.write(item.data, chosen.kind, spectra.paint_layers(item, chosen, entry, source), color=color)
    if isinstance(entry.result, VertexWords):
        bag_chart.show(item, entry.result.bag)
    elif isinstance(entry.result, VertexSpectrum):
        _ranges[item.session_uid] = _Range(*time_range(entry.result.spectrum), entry.size)


def repaint(context: Any, chosen: Painting, color: bool) -> None:
    """Paint those selected objects again that are painted and whose spectrum is known; cheap.

    Parameters
    ----------
    context : bpy.types.Context
    chosen : Painting
    color : bool
        As in `apply`.
    """
    if chosen.kind not in TIMED + SEVERAL:
        return
    for item in targets(getattr(context, "selected_objects", ()))[0]:
        if attributes.is_painted(item.data, chosen.kind):
            entry = spectra.known(spectra.key_of(item, chosen, None))
            if entry is not None and (chosen.kind != "HEAT" or attributes.picked_vertex(item) is not None):
                apply(item, chosen, entry, color=color)


def scale_text(item: Any, chosen: Painting, units: Any) -> str:
    """How far heat has spread on an object at the time of the slider.

    Parameters
    ----------
    item : bpy.types.Object
    chosen : Painting
    units : bpy.types.UnitSettings

    Returns
    -------
    text : str
        Such as "0.12 m · 3.4 % of its size"; empty for an object that was not painted since the file
        was opened.
    """
    known = _ranges.get(item.session_uid)
    if known is None:
        return ""
    time = known.shortest * (known.longest / known.shortest) ** chosen.scale
    return distance_text(math.sqrt(time), known.size, units)


def distance_text(distance: float, size: float, units: Any) -> str:
    """Write a distance in the scene's units and as a share of an object's size.

    Parameters
    ----------
    distance, size : float
        In world units.
    units : bpy.types.UnitSettings

    Returns
    -------
    text : str
    """
    if units.system == "NONE":  # for which Blender's own function crashes
        length = f"{distance:.3g}"
    else:
        length = bpy.utils.units.to_string(
            units.system, "LENGTH", distance * units.scale_length, precision=3, compatible_unit=True
        )
    return f"{length} · {100 * distance / size:.1f} % of its size" if size > 0 else length


def clear() -> None:
    """Forget all objects."""
    _ranges.clear()
