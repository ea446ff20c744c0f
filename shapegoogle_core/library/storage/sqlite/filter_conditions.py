# SPDX-License-Identifier: MIT
"""SQL conditions of a `Filter`: on the name, folder, tag, faces and size of shapes."""

from __future__ import annotations

import os
from collections.abc import Iterator

from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.storage.sqlite.database import encoded

__all__ = ["filter_conditions", "fold_case"]

WILDCARDS = {"*": "%", "?": "_"}
LARGEST_EXTENT = "max(extent_x, extent_y, extent_z)"

Condition = tuple[str, tuple[object, ...]]
"""A condition on the table `shapes`, and the values of its question marks."""


def filter_conditions(where: Filter) -> Condition:
    """Translate the conditions of a filter that are known before a search.

    Parameters
    ----------
    where : Filter

    Returns
    -------
    condition : str
        A condition on the table `shapes`; always true if the filter has none. It calls the SQL function
        `fold_case` if the name has letters beyond ASCII.
    parameters : tuple
        Values for its question marks.
    """
    conditions = list(_conditions(where))
    statement = " AND ".join(f"({condition})" for condition, _ in conditions)
    return statement or "TRUE", tuple(value for _, values in conditions for value in values)


def fold_case(name: bytes) -> bytes:
    """Remove the differences between upper and lower case from a name.

    Parameters
    ----------
    name : bytes
        In UTF-8, surrogates included.

    Returns
    -------
    folded : bytes
    """
    return name.decode("utf-8", "surrogatepass").casefold().encode("utf-8", "surrogatepass")


def _conditions(where: Filter) -> Iterator[Condition]:
    if where.name is not None:
        yield _name_condition(where.name)
    if where.folder is not None:
        yield _folder_condition(os.fspath(where.folder))
    if where.tag is not None:
        yield "id IN (SELECT shape_id FROM tags WHERE tag = CAST(? AS TEXT))", (encoded(where.tag),)
    for column, limits in (("face_count", where.faces), (LARGEST_EXTENT, where.size)):
        low, high = limits or (None, None)
        if low is not None:
            yield f"{column} >= ?", (float(low),)
        if high is not None:
            yield f"{column} <= ?", (float(high),)


def _name_condition(name: str) -> Condition:
    """Compare whole names with a pattern that has wildcards; else search the text anywhere in a name."""
    escaped = name.translate({ord(character): f"\\{character}" for character in "\\%_"})
    for wildcard, translated in WILDCARDS.items():
        escaped = escaped.replace(wildcard, translated)
    pattern = escaped if any(wildcard in name for wildcard in WILDCARDS) else f"%{escaped}%"
    if name.isascii():  # LIKE ignores case, but only of ASCII letters
        return "name LIKE CAST(? AS TEXT) ESCAPE '\\'", (encoded(pattern),)
    folded = "CAST(fold_case(CAST(name AS BLOB)) AS TEXT)"
    return f"{folded} LIKE CAST(? AS TEXT) ESCAPE '\\'", (fold_case(encoded(pattern)),)


def _folder_condition(folder: str) -> Condition:
    """Compare the beginnings of paths, up to a separator; sources are usually absolute paths."""
    absolute = os.path.abspath(folder)  # noqa: PTH100 - `resolve` would follow links, which sources do not
    prefixes = {
        path if path.endswith(("/", "\\")) else path + separator
        for path in (folder, absolute)
        for separator in "/\\"
    }
    starts = " OR ".join(["substr(path, 1, ?) = CAST(? AS TEXT)"] * len(prefixes))
    values = tuple(value for prefix in sorted(prefixes) for value in (len(prefix), encoded(prefix)))
    return f"source_id IN (SELECT id FROM sources WHERE {starts})", values
