# SPDX-License-Identifier: GPL-3.0-or-later
"""German, in the words of Blender's own German translation: mesh is "Masche", vertex "Punkt".

Where Blender itself has a text, its translation wins over the one here: both are to be the same.
"""

from __future__ import annotations

from . import core, decisions, duplicates, gallery, gallery_editor, library, server, signature

__all__ = ["COUNTED", "LOCALE", "OPERATORS", "TEXTS", "form"]

LOCALE = "de"

_PARTS = (library, gallery, gallery_editor, signature, duplicates, decisions, server, core)

TEXTS = {text: translated for part in _PARTS for text, translated in part.TEXTS.items()}
# On buttons, where a word means something else than in a label.
OPERATORS = {text: translated for part in _PARTS for text, translated in part.OPERATORS.items()}
COUNTED = {text: forms for part in _PARTS for text, forms in part.COUNTED.items()}


def form(count: int) -> int:
    """Return which of the forms in `COUNTED` belongs to a number: that for one, or that for others."""
    return int(count != 1)
