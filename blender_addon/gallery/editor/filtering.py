# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the matches shown have a text, until the library has answered."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from typing import Any

__all__ = ["has_text", "with_text"]

_WILDCARDS = "*?"


def has_text(texts: Iterable[str], wanted: str) -> bool:
    """Whether any of several texts contains a text, in upper or lower case.

    Parameters
    ----------
    texts : iterable of str
    wanted : str
        With ``*`` or ``?``, a whole text has to be like it; as in the filter of the search.

    Returns
    -------
    found : bool
    """
    wanted = wanted.strip().casefold()
    if any(wildcard in wanted for wildcard in _WILDCARDS):
        pattern = wanted.replace("[", "[[]")
        return any(fnmatchcase(text.casefold(), pattern) for text in texts)
    return any(wanted in text.casefold() for text in texts)


def with_text(lines: Sequence[Any], wanted: str) -> list[int]:
    """Return the indices of the matches that have a text in their name, tags, catalog or path.

    Parameters
    ----------
    lines : sequence of SHAPEGOOGLE_PG_match
    wanted : str
        Without one, all have it.

    Returns
    -------
    indices : list of int
    """
    if not wanted.strip():
        return list(range(len(lines)))
    return [
        index
        for index, line in enumerate(lines)
        if has_text((line.name, line.object_name, line.title, line.tags, line.catalog, line.source), wanted)
    ]
