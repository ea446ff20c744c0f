# SPDX-License-Identifier: GPL-3.0-or-later
"""The chosen match, and the base of all operators that use it."""

from __future__ import annotations

from typing import Any

from ..state import session_of
from ..translation import tr

__all__ = ["OnMatch", "active_match", "shown_lines"]


def shown_lines(session: Any) -> tuple[Any, int]:
    """Return what the gallery shows: the matches, or the versions of one of them.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session

    Returns
    -------
    lines : collection of SHAPEGOOGLE_PG_match
    active : int
        Index of the chosen one; it may be none of them.
    """
    if session.opened >= 0:
        return session.versions, session.active_version
    return session.matches, session.active_match


def active_match(context: Any) -> Any:
    """Return the chosen match, or None."""
    lines, active = shown_lines(session_of(context))
    return lines[active] if 0 <= active < len(lines) else None


class OnMatch:
    """Base of the operators on the chosen match."""

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a match is chosen."""
        if active_match(context) is None:
            cls.poll_message_set(tr("Find similar shapes and choose a match first"))  # type: ignore[attr-defined]
            return False
        return True
