# SPDX-License-Identifier: GPL-3.0-or-later
"""The filters of the panel Search, as conditions of the search itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..library.open_file import open_source

if TYPE_CHECKING:
    from shapegoogle_core import Filter

__all__ = ["conditions", "is_filtered", "size_factor"]


def conditions(session: Any) -> Filter:
    """Return what the user asks of matches, except their size.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session

    Returns
    -------
    where : Filter
    """
    from shapegoogle_core import Filter

    return Filter(
        text=session.text.strip() or None,
        sources=(open_source(),) if session.source == "SCENE" else None,
        not_sources=(open_source(),) if session.source == "FILES" else None,
        min_similarity=session.least_similarity or None,
    )


def size_factor(session: Any) -> float | None:
    """Return the largest factor between the sizes of query and match; None if any size will do.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session

    Returns
    -------
    factor : float or None
    """
    return 1 + session.size_tolerance / 100 if session.use_size else None


def is_filtered(session: Any) -> bool:
    """Whether any filter is set; cheap enough for a panel."""
    return bool(
        session.text.strip() or session.source != "ANY" or session.least_similarity > 0 or session.use_size
    )
