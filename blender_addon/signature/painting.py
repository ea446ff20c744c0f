# SPDX-License-Identifier: GPL-3.0-or-later
"""Put paintings onto objects: which objects can be painted, painting them, painting them again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy

from .. import state
from ..scene.selection import mesh_objects, split_evaluated
from ..translation import tr
from . import attributes, bag_chart, results
from .choices import SEVERAL, TIMED, Painting
from .distance import TimeRange
from .picked import picked
from .results import Known

__all__ = ["apply", "repaint", "targets"]


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
    meshes = mesh_objects(objects)
    hidden = set(split_evaluated(meshes, bpy.context)[1])
    for item in meshes:
        if item in hidden:
            text = tr(
                "{name!r} is disabled in viewports or in an excluded collection, so that its scale is not "
                "known; show it first"
            )
            refused.append(text.format(name=item.name))
        elif not item.data.is_editable:
            text = tr("{name!r} has its mesh in another file; make it local first")
            refused.append(text.format(name=item.name))
        elif item.data not in seen:
            seen.add(item.data)
            items.append(item)
    return items, refused


def apply(
    item: Any,
    chosen: Painting,
    entry: Known,
    *,
    color: bool = True,
    keep: bool = False,
    source: int | None = None,
) -> None:
    """Write the result of a computation onto the vertices of an object.

    Parameters
    ----------
    item : bpy.types.Object
    chosen : Painting
    entry : Known
    color : bool
        Whether to write the colour attribute.
    keep : bool
        Whether attributes of other kinds stay.
    source : int, optional
        Vertex that heat spreads from; left out, the one that is selected.

    Raises
    ------
    MeshError
        If the object has no such values.
    """
    from shapegoogle_core import VertexSpectrum, VertexWords
    from shapegoogle_core.descriptors import time_range

    layers = results.paint_layers(item, chosen, entry, source)
    attributes.write(item.data, chosen.kind, layers, color=color, keep=keep)
    if isinstance(entry.result, VertexWords):
        bag_chart.show(item, entry.result.bag)
    elif isinstance(entry.result, VertexSpectrum):
        shortest, longest = time_range(entry.result.spectrum)
        state.current().signature.times[item.session_uid] = TimeRange(shortest, longest, entry.size)


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
            entry = results.known(results.key_of(item, chosen, None))
            if entry is not None and (chosen.kind != "HEAT" or picked(item) is not None):
                apply(item, chosen, entry, color=color, keep=True)
