# SPDX-License-Identifier: GPL-3.0-or-later
"""German, in the words of Blender's own German translation."""

from __future__ import annotations

__all__ = ["COUNTED", "LOCALE", "OPERATORS", "TEXTS", "form"]

LOCALE = "de"

TEXTS: dict[str, str] = {}

# On buttons, where a word means something else than in a label.
OPERATORS: dict[str, str] = {}

COUNTED: dict[str, tuple[str, ...]] = {}


def form(count: int) -> int:
    """Return which of the forms in `COUNTED` belongs to a number: that for one, or that for others."""
    return int(count != 1)
