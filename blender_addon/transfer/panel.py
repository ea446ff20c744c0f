# SPDX-License-Identifier: GPL-3.0-or-later
"""The transfer in the panel Search: its button, and what is transferred."""

from __future__ import annotations

from typing import Any

from .. import state
from ..translation import tr

__all__ = ["draw_choices", "draw_transfer"]


def draw_transfer(row: Any) -> None:
    """Draw the button, with how far the transfer that runs has come, and the one that cancels it.

    Parameters
    ----------
    row : bpy.types.UILayout
    """
    running = state.current().transfer.operator
    text = running.waits_for if running is not None else tr("Transfer")
    row.operator("shape_google.transfer_match", text=text, translate=False, icon="MOD_DATA_TRANSFER")
    row.operator("shape_google.cancel_transfer", text="", icon="X")


def draw_choices(layout: Any, session: Any) -> None:
    """Draw the choices of what to transfer.

    Parameters
    ----------
    layout : bpy.types.UILayout
    session : SHAPEGOOGLE_PG_session
    """
    header, body = layout.panel("SHAPEGOOGLE_transfer", default_closed=True)
    header.label(text="What to Transfer")
    if body is None:
        return
    body.use_property_split = True
    body.use_property_decorate = False
    column = body.column(heading="Carry Over")
    column.prop(session, "transfer_groups")
    column.prop(session, "transfer_colors")
    column.prop(session, "transfer_uvs")
    body.prop(session, "transfer_replace")
