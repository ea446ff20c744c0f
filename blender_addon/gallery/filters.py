# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the matches are shown, by the filters in the panel Search."""

from __future__ import annotations

from typing import Any

__all__ = ["shown_matches"]


def shown_matches(session: Any) -> list[tuple[int, Any]]:
    """Return the matches that pass the filters, best first, each with its index.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session

    Returns
    -------
    shown : list of (int, SHAPEGOOGLE_PG_match)
    """
    text = session.text.strip().lower()
    factor = 1 + session.size_tolerance / 100
    best: dict[tuple[float, int, float], int] = {}  # of each shape the place among those shown
    shown: list[tuple[int, Any]] = []
    for index, match in enumerate(session.matches):
        if match.similarity < session.least_similarity:
            continue
        if session.use_size and not 1 / factor <= match.size <= factor:
            continue
        if session.source != "ANY" and match.in_scene != (session.source == "SCENE"):
            continue
        if text and text not in f"{match.name}\n{match.source}".lower():
            continue
        # Equal distances to six digits and as many vertices: the same mesh, wherever it is.
        # Of several examples all copies have distance 0: the sizes of their poses tell them apart.
        size = round(match.size, 3) if session.asked > 1 else 0.0
        key = round(match.distance, 6), match.vertex_count, size
        if session.collapse and key in best:
            # The one that can be selected stands for its copies in files.
            if match.in_scene and not shown[best[key]][1].in_scene:
                shown[best[key]] = index, match
            continue
        best.setdefault(key, len(shown))
        shown.append((index, match))
    return shown
