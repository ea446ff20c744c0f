# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of using a match."""

from __future__ import annotations

from ..translation import marked
from ..translation.errors import TextError

__all__ = ["GONE", "PlacingError"]

GONE = marked(
    "{name!r} is not in this scene any more: it was deleted, or renamed and changed; undo that, or index "
    "This Scene and search again"
)
"""Of an object that was in the open scene when it was indexed."""


class PlacingError(TextError):
    """A shape cannot be brought into or found in the scene; the message gives the reason and what to do."""
