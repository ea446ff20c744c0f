# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the session that say which layers are transferred."""

from __future__ import annotations

from bpy.props import BoolProperty

__all__ = ["TransferProperties"]


class TransferProperties:
    """Part of the session: choices of the transfer."""

    transfer_groups: BoolProperty(
        name="Vertex Groups", description="Transfer vertex groups with their weights", default=True
    )
    transfer_colors: BoolProperty(name="Colors", description="Transfer color attributes", default=True)
    transfer_uvs: BoolProperty(name="UVs", description="Transfer UV maps", default=True)
    transfer_replace: BoolProperty(
        name="Replace Existing",
        description="Overwrite vertex groups, color attributes and UV maps of the same name",
        default=False,
    )
