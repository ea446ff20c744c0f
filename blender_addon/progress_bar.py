# SPDX-License-Identifier: GPL-3.0-or-later
"""`progress_bar`: the progress of something that runs, in a row of buttons."""

from __future__ import annotations

from typing import Any

from bpy.props import FloatProperty

__all__ = ["percentage", "progress_bar"]


def percentage(name: str) -> Any:
    """Make a property that shows another one, a share from 0 to 1, in percent; for `progress_bar`.

    Parameters
    ----------
    name : str
        The other property, of the same owner.
    """
    return FloatProperty(
        name="Progress",
        description="Share of the work that is done",
        subtype="PERCENTAGE",
        min=0,
        max=100,
        precision=0,
        get=lambda owner: 100 * min(max(getattr(owner, name), 0.0), 1.0),
    )


def progress_bar(layout: Any, owner: Any, name: str, text: str = "") -> None:
    """Show a property from 0 to 1 as a bar.

    Not by `layout.progress`: Blender does not tell its buttons from labels. If the pointer rests on such a
    button when the work ends, the next text of the panel is drawn as a full bar until the pointer moves; and
    it rests there, since the button that started the work was in the same place.

    Parameters
    ----------
    layout : bpy.types.UILayout
    owner : bpy.types.PropertyGroup
    name : str
        The property, made by `percentage`.
    text : str, optional
        Written before the number; translated already.
    """
    layout.prop(owner, name, text=text, translate=False, slider=True)
