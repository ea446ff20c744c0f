# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of using a match."""

from __future__ import annotations

from ..translation.errors import TextError

__all__ = ["PlacingError"]


class PlacingError(TextError):
    """A shape cannot be brought into or found in the scene; the message gives the reason and what to do."""
