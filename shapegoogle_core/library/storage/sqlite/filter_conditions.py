# SPDX-License-Identifier: MIT
"""SQL conditions of a `Filter`: on the name, source, tag, faces and size of shapes."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence

from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.roots.keys import source_keys
from shapegoogle_core.library.roots.paths import path_key, relative_to, spellings
from shapegoogle_core.library.storage.records import Root
from shapegoogle_core.library.storage.sqlite.database import encoded

__all__ = ["filter_conditions", "fold_case"]

WILDCARDS = {"*": "%", "?": "_"}
LARGEST_EXTENT = "max(extent_x, extent_y, extent_z)"

Condition = tuple[str, tuple[object, ...]]
"""A condition on the table `shapes`, and the values of its question marks."""


def filter_conditions(where: Filter, roots: Sequence[Root]) -> Condition:
    """Translate the conditions of a filter that are known before a search.

    Parameters
    ----------
    where : Filter
    roots : sequence of Root
        Of the library.

    Returns
    -------
    condition : str
        A condition on the table `shapes`; always true if the filter has none. It calls the SQL function
        `fold_case` if the name has letters beyond ASCII.
    parameters : tuple
        Values for its question marks.
    """
    conditions = list(_conditions(where, roots))
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


def _conditions(where: Filter, roots: Sequence[Root]) -> Iterator[Condition]:
    if where.name is not None:
        yield _name_condition(where.name)
    if where.text is not None:
        yield _text_condition(where.text)
    if where.folder is not None:
        yield _folder_condition(os.fspath(where.folder), roots)
    if where.sources is not None:
        yield _source_condition(where.sources, roots)
    if where.not_sources:
        condition, values = _source_condition(where.not_sources, roots)
        yield f"NOT coalesce({condition}, FALSE)", values
    if where.tag is not None:
        yield "id IN (SELECT shape_id FROM tags WHERE tag = CAST(? AS TEXT))", (encoded(where.tag),)
    if where.file_type is not None:
        yield _type_condition(where.file_type)
    if where.faces is not None:
        yield _range_condition("face_count", where.faces)
    if where.size is not None:
        own, values = _range_condition(LARGEST_EXTENT, where.size)
        yield f"{own} OR id IN (SELECT shape_id FROM placements WHERE {own})", 2 * values
    if where.area is not None:
        yield _range_condition("area", where.area)


def _range_condition(column: str, limits: tuple[float | None, float | None]) -> Condition:
    """Compare a column with a low and a high limit."""
    parts = [
        (f"{column} {comparison} ?", float(limit))
        for comparison, limit in zip((">=", "<="), limits, strict=True)
        if limit is not None
    ]
    return " AND ".join(part for part, _ in parts) or "TRUE", tuple(limit for _, limit in parts)


def _name_condition(name: str) -> Condition:
    """Search a text in the names of shapes and of the objects that show them."""
    like, value = _like(name)
    own, other = like.format(column="name"), like.format(column="object_name")
    # The first placement has the name of the shape, unless the shape was renamed.
    return f"{own} OR id IN (SELECT shape_id FROM placements WHERE {other})", (value, value)


def _type_condition(file_type: str) -> Condition:
    """Search sources whose names end in a dot and a text."""
    like, value = _like(f"*.{_literal(file_type.strip().lstrip('*').lstrip('.'))}")
    return f"source_id IN (SELECT id FROM sources WHERE {like.format(column='path')})", (value,)


def _literal(text: str) -> str:
    """Remove wildcards."""
    return "".join(character for character in text if character not in WILDCARDS)


def _text_condition(text: str) -> Condition:
    """Search a text in names, and in the full paths of sources."""
    name, values = _name_condition(text)
    like, value = _like(text)
    path = like.format(column="(coalesce(roots.path || '/', '') || sources.path)")
    sources = f"SELECT sources.id FROM sources LEFT JOIN roots ON roots.id = root_id WHERE {path}"
    return f"{name} OR source_id IN ({sources})", (*values, value)


def _like(name: str) -> tuple[str, object]:
    """Compare whole texts with a pattern that has wildcards; else search the text anywhere in them.

    Returns
    -------
    like : str
        Condition on a column, which is to be filled in.
    value : object
        For its question mark.
    """
    escaped = name.translate({ord(character): f"\\{character}" for character in "\\%_"})
    for wildcard, translated in WILDCARDS.items():
        escaped = escaped.replace(wildcard, translated)
    pattern = escaped if any(wildcard in name for wildcard in WILDCARDS) else f"%{escaped}%"
    if name.isascii():  # LIKE ignores case, but only of ASCII letters
        return "{column} LIKE CAST(? AS TEXT) ESCAPE '\\'", encoded(pattern)
    like = "CAST(fold_case(CAST({column} AS BLOB)) AS TEXT) LIKE CAST(? AS TEXT) ESCAPE '\\'"
    return like, fold_case(encoded(pattern))


def _folder_condition(folder: str, roots: Sequence[Root]) -> Condition:
    """Find the sources below a folder: whole roots, the beginnings of paths below a root, and of labels."""
    conditions: list[Condition] = []
    folders = spellings(folder)
    for root in roots:
        below = [relative_to(spelling, root.path) for spelling in folders]
        if any(relative_to(root.path, spelling) is not None for spelling in folders):
            conditions.append(
                ("root_id = (SELECT id FROM roots WHERE name = CAST(? AS TEXT))", (encoded(root.name),))
            )
        elif part := next((relative for relative in below if relative), ""):
            prefix = path_key(root.path, part) + "/"
            conditions.append(
                (
                    "root_id = (SELECT id FROM roots WHERE name = CAST(? AS TEXT))"
                    " AND substr(key, 1, ?) = CAST(? AS TEXT)",
                    (encoded(root.name), len(prefix), encoded(prefix)),
                )
            )
    prefixes = {
        path if path.endswith(("/", "\\")) else path + separator
        for path in (folder, *folders)
        for separator in "/\\"
    }
    conditions += [
        ("root_id IS NULL AND substr(path, 1, ?) = CAST(? AS TEXT)", (len(prefix), encoded(prefix)))
        for prefix in sorted(prefixes)
    ]
    return _any_source(conditions)


def _source_condition(sources: Sequence[str], roots: Sequence[Root]) -> Condition:
    """Find some sources by their full paths or labels."""
    keys = {key for source in sources for key in source_keys(source, roots)}
    paths = {root.name: root.path for root in roots}
    return _any_source(
        [
            (
                "coalesce((SELECT name FROM roots WHERE roots.id = root_id), '') = CAST(? AS TEXT)"
                " AND key = CAST(? AS TEXT)",
                (encoded(key.root), encoded(path_key(paths[key.root], key.path) if key.root else key.path)),
            )
            for key in sorted(keys)
        ]
    )


def _any_source(conditions: Sequence[Condition]) -> Condition:
    starts = _either([condition for condition, _ in conditions])
    values = tuple(value for _, own in conditions for value in own)
    return f"source_id IN (SELECT id FROM sources WHERE {starts})", values


def _either(conditions: Sequence[str]) -> str:
    """Join conditions by OR as a balanced tree: SQLite refuses expressions of a depth above 1,000."""
    if len(conditions) < 2:
        return conditions[0] if conditions else "FALSE"
    middle = len(conditions) // 2
    return f"({_either(conditions[:middle])}) OR ({_either(conditions[middle:])})"
