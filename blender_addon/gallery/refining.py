# SPDX-License-Identifier: GPL-3.0-or-later
"""Answering the present query again once a filter has changed: the shapes need not be described again."""

from __future__ import annotations

import time
from typing import Any

import bpy

from .. import state

__all__ = ["search_again"]

# Seconds without a further change: while someone types or drags, nothing is searched.
PATIENCE = 0.3


def search_again(_session: Any, _context: Any) -> None:
    """Search again in a moment; the update function of all filters.

    Without a window the next search takes them into account.
    """
    search = state.current().search
    if bpy.app.background or search.answer is None:
        return
    waits = search.refine_at > 0
    search.refine_at = time.monotonic() + PATIENCE
    if not waits:
        bpy.app.timers.register(_look, first_interval=PATIENCE, persistent=True)


def _look() -> float | None:
    if not state.is_registered():
        return None
    search = state.current().search
    remaining = search.refine_at - time.monotonic()
    if remaining > 0:
        return remaining
    search.refine_at = 0.0
    from ..search.operators import refine

    refine(bpy.context)
    return None
