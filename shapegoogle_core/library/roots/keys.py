# SPDX-License-Identifier: MIT
"""From a path as a user writes it to the key of a source."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from shapegoogle_core.library.roots.paths import containing_root, spellings
from shapegoogle_core.library.storage.records import Root, SourceKey

__all__ = ["key_below", "source_keys"]


def source_keys(source: str, roots: Sequence[Root]) -> list[SourceKey]:
    """List the keys that a source may have, the likeliest first.

    Parameters
    ----------
    source : str
        A label, exactly; or any spelling of the path of a file.
    roots : sequence of Root
        Of the library.

    Returns
    -------
    keys : list of SourceKey
    """
    keys = [SourceKey("", source)]
    for spelling in spellings(source):
        if (key := _key(spelling, roots)) is not None:
            keys.append(key)
        keys.append(SourceKey("", spelling))
    return list(dict.fromkeys(keys))


def key_below(
    path: str, roots: Sequence[Root], follow: Callable[[str], str] = os.path.realpath
) -> SourceKey | None:
    """Return the key of a file below a root.

    Parameters
    ----------
    path : str
        Any spelling.
    roots : sequence of Root
        Of the library.
    follow : callable, optional
        See `spellings`.

    Returns
    -------
    key : SourceKey or None
        None if the file lies below no root.
    """
    return next((key for path in spellings(path, follow) if (key := _key(path, roots)) is not None), None)


def _key(path: str, roots: Sequence[Root]) -> SourceKey | None:
    found = containing_root(path, [root.path for root in roots])
    if found is None or not found[1]:
        return None
    return SourceKey(roots[found[0]].name, found[1])
