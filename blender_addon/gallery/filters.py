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

    least, most = session.least_faces or None, session.most_faces or None
    if least is not None and most is not None and most < least:
        least, most = most, least
    return Filter(
        text=session.text.strip() or None,
        tag=session.tag.strip() or None,
        catalog=session.catalog.strip().strip("/") or None,
        shape_type=None if session.shape_type == "ANY" else session.shape_type,
        faces=None if least is None and most is None else (least, most),
        kind=None if session.evidence == "ANY" else session.evidence,
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
    texts = (session.text, session.tag, session.catalog.strip().strip("/"))
    return bool(
        any(text.strip() for text in texts)
        or any(choice != "ANY" for choice in (session.source, session.shape_type, session.evidence))
        or session.least_similarity > 0
        or session.least_faces
        or session.most_faces
        or session.use_size
    )
