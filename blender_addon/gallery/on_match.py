# SPDX-License-Identifier: GPL-3.0-or-later
"""The chosen match, and the base of all operators that use it."""

from __future__ import annotations

from typing import Any

from ..state import session_of

__all__ = ["OnMatch", "active_match"]


def active_match(context: Any) -> Any:
    """Return the chosen match, or None."""
    session = session_of(context)
    return session.matches[session.active_match] if 0 <= session.active_match < len(session.matches) else None


class OnMatch:
    """Base of the operators on the chosen match."""

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a match is chosen."""
        if active_match(context) is None:
            cls.poll_message_set("Find similar shapes and choose a match first")  # type: ignore[attr-defined]
            return False
        return True
