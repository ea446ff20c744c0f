# SPDX-License-Identifier: MIT
"""SQL conditions of a `Filter`: on the name, source, tag, faces and size of shapes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.origin import ShapeType
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.roots.keys import source_keys
from shapegoogle_core.library.roots.paths import path_key, relative_to, spellings
from shapegoogle_core.library.storage.records import Root

__all__ = [
    "CATALOG",
    "NAME",
    "OBJECT_NAME",
    "PATH",
    "TAG",
    "Dialect",
    "filter_conditions",
    "folded",
    "kept_by_area",
]

WILDCARDS = {"*": "%", "?": "_"}

NAME = "name"
"""Column of the names of shapes."""

OBJECT_NAME = "object_name"
"""Column of the names of placements."""

TAG = "tag"
"""Column of tags."""

CATALOG = "catalog"
"""Column of the paths of catalogs."""

PATH = "(coalesce(roots.path || '/', '') || sources.path)"
"""Full path of a source."""

Condition = tuple[str, tuple[object, ...]]
"""A condition on the table `shapes`, and the values of its placeholders."""


@dataclass(frozen=True)
class Dialect:
    """What differs between databases.

    Attributes
    ----------
    value, text : str
        Placeholders of a number and of a text.
    encoded : callable
        Turns a text into its value for the client.
    like : str
        Comparison of a column with a pattern, in which a backslash makes a wildcard a plain character. It
        ignores the case of ASCII letters.
    exactly_like : str
        The same for a folded column and a folded pattern.
    folded : callable
        Makes the expression of one of the columns above without differences of case.
    greatest : str
        Function that returns the largest of its arguments.
    """

    value: str
    text: str
    encoded: Callable[[str], object]
    like: str
    exactly_like: str
    folded: Callable[[str], str]
    greatest: str


def folded(name: str) -> str | None:
    """Remove the differences between upper and lower case from a name with letters beyond ASCII.

    Parameters
    ----------
    name : str

    Returns
    -------
    folded : str or None
        None for a name of ASCII characters, which a database compares itself.
    """
    return None if name.isascii() else name.casefold()


def filter_conditions(
    where: Filter, roots: Sequence[Root], dialect: Dialect, *, with_origins: bool = True
) -> Condition:
    """Translate the conditions of a filter that are known before a search.

    Parameters
    ----------
    where : Filter
    roots : sequence of Root
        Of the library.
    dialect : Dialect
    with_origins : bool, optional
        Whether the library has the table `origins`.

    Returns
    -------
    condition : str
        A condition on the table `shapes`; always true if the filter has none.
    parameters : tuple
        Values for its placeholders.
    """
    conditions = list(_Conditions(roots, dialect, with_origins=with_origins).of(where))
    statement = " AND ".join(f"({condition})" for condition, _ in conditions)
    return statement or "TRUE", tuple(value for _, values in conditions for value in values)


def kept_by_area(
    where: Filter,
    rows: Sequence[tuple[Any, ...]],
    placements: Callable[[Sequence[int]], Mapping[int, Sequence[Placement]]],
) -> list[int]:
    """Keep the shapes of which any placement has an area in the range of a filter.

    Parameters
    ----------
    where : Filter
    rows : sequence of (int, float)
        Ids of the shapes that meet its conditions in SQL, and their areas at their first placements.
    placements : callable
        Finds the placements of shapes.

    Returns
    -------
    shape_ids : list of int
        In their order.
    """
    others = [shape_id for shape_id, area in rows if not where.accepts_area(area)]
    if not others:
        return [shape_id for shape_id, _ in rows]
    areas, found = dict(rows), placements(others)
    dropped = {
        shape_id
        for shape_id in others
        if not any(
            where.accepts_area(areas[shape_id] * (placed.scale / found[shape_id][0].scale) ** 2)
            for placed in found.get(shape_id, ())
        )
    }
    return [shape_id for shape_id, _ in rows if shape_id not in dropped]


class _Conditions:
    """Writes the conditions of a filter."""

    def __init__(self, roots: Sequence[Root], dialect: Dialect, *, with_origins: bool) -> None:
        self._with_origins = with_origins
        self._roots = roots
        self._dialect = dialect

    def of(self, where: Filter) -> Iterator[Condition]:
        """List the conditions of a filter."""
        if where.name is not None:
            yield self._name(where.name)
        if where.text is not None:
            yield self._text(where.text)
        if where.folder is not None:
            yield self._folder(os.fspath(where.folder))
        if where.sources is not None:
            yield self._sources(where.sources)
        if where.not_sources:
            condition, values = self._sources(where.not_sources)
            yield f"NOT coalesce({condition}, FALSE)", values
        if where.tag is not None:
            tagged = f"id IN (SELECT shape_id FROM tags WHERE tag = {self._dialect.text})"
            yield tagged, (self._dialect.encoded(where.tag),)
        if where.catalog is not None:
            yield self._catalog(where.catalog)
        if where.shape_type is not None:
            yield self._shape_type(where.shape_type)
        if where.file_type is not None:
            yield self._type(where.file_type)
        if where.faces is not None:
            yield self._range("face_count", where.faces)
        if where.size is not None:
            largest = f"{self._dialect.greatest}(extent_x, extent_y, extent_z)"
            own, values = self._range(largest, where.size)
            yield f"{own} OR id IN (SELECT shape_id FROM placements WHERE {own})", 2 * values
        if where.area is not None:
            own, values = self._range("area", where.area)
            # Sizes of other placements follow from their matrices, see `kept_by_area`.
            yield f"{own} OR placement_count > 1", values

    def _range(self, column: str, limits: tuple[float | None, float | None]) -> Condition:
        """Compare a column with a low and a high limit."""
        parts = [
            (f"{column} {comparison} {self._dialect.value}", float(limit))
            for comparison, limit in zip((">=", "<="), limits, strict=True)
            if limit is not None
        ]
        return " AND ".join(part for part, _ in parts) or "TRUE", tuple(limit for _, limit in parts)

    def _name(self, name: str) -> Condition:
        """Search a text in the names of shapes and of the objects that show them."""
        own, value = self._like(NAME, name)
        other, _ = self._like(OBJECT_NAME, name)
        # The first placement has the name of the shape, unless the shape was renamed.
        return f"{own} OR id IN (SELECT shape_id FROM placements WHERE {other})", (value, value)

    def _type(self, file_type: str) -> Condition:
        """Search sources whose names end in a dot and a text."""
        pattern = f"*.{_literal(file_type.strip().lstrip('*').lstrip('.'))}"
        like, value = self._like(PATH, pattern)
        return f"source_id IN ({_SOURCES} WHERE {like})", (value,)

    def _text(self, text: str) -> Condition:
        """Search a text in names, tags and catalogs, and in the full paths of sources."""
        condition, values = self._name(text)
        like, value = self._like(PATH, text)
        condition += f" OR source_id IN ({_SOURCES} WHERE {like})"
        for table, column in (("tags", TAG), ("origins", CATALOG))[: 1 + self._with_origins]:
            like, _ = self._like(column, text)
            condition += f" OR id IN (SELECT shape_id FROM {table} WHERE {like})"
        return condition, (*values, *[value] * (2 + self._with_origins))

    def _catalog(self, catalog: str) -> Condition:
        """Find shapes in a catalog or below it, ignoring the case of ASCII letters."""
        if not self._with_origins:
            return "FALSE", ()
        path, text = catalog.strip().strip("/"), self._dialect.text
        encoded = self._dialect.encoded
        return (
            f"id IN (SELECT shape_id FROM origins WHERE lower(catalog) = lower({text})"
            f" OR lower(substr(catalog, 1, {self._dialect.value})) = lower({text}))",
            (encoded(path), len(path) + 1, encoded(f"{path}/")),
        )

    def _shape_type(self, shape_type: ShapeType) -> Condition:
        """Find shapes of a type; those without a row are objects, or files without an object name."""
        plain = {"object": "object_name <> ''", "file": "object_name = ''"}.get(shape_type, "FALSE")
        if not self._with_origins:
            return plain, ()
        return (
            f"id IN (SELECT shape_id FROM origins WHERE shape_type = {self._dialect.text})"
            f" OR ({plain} AND id NOT IN (SELECT shape_id FROM origins))",
            (self._dialect.encoded(shape_type),),
        )

    def _like(self, column: str, text: str) -> tuple[str, object]:
        """Compare whole texts with a pattern that has wildcards; else search the text anywhere in them."""
        pattern = _pattern(text)
        if text.isascii():
            return self._dialect.like.format(column), self._dialect.encoded(pattern)
        condition = self._dialect.exactly_like.format(self._dialect.folded(column))
        return condition, self._dialect.encoded(pattern.casefold())

    def _folder(self, folder: str) -> Condition:
        """Find the sources below a folder: whole roots, beginnings of paths below a root, and of labels."""
        conditions: list[Condition] = []
        folders = spellings(folder)
        encoded, text = self._dialect.encoded, self._dialect.text
        for root in self._roots:
            of_root = f"root_id = (SELECT id FROM roots WHERE name = {text})"
            below = [relative_to(spelling, root.path) for spelling in folders]
            if any(relative_to(root.path, spelling) is not None for spelling in folders):
                conditions.append((of_root, (encoded(root.name),)))
            elif part := next((relative for relative in below if relative), ""):
                condition, values = self._begins("key", path_key(root.key_folder, part) + "/")
                conditions.append((f"{of_root} AND {condition}", (encoded(root.name), *values)))
        prefixes = {
            path if path.endswith(("/", "\\")) else path + separator
            for path in (folder, *folders)
            for separator in "/\\"
        }
        labels = [self._begins("path", prefix) for prefix in sorted(prefixes)]
        conditions += [(f"root_id IS NULL AND {condition}", values) for condition, values in labels]
        return _any_source(conditions)

    def _begins(self, column: str, prefix: str) -> Condition:
        """Compare the beginning of a column with a text."""
        condition = f"substr({column}, 1, {self._dialect.value}) = {self._dialect.text}"
        return condition, (len(prefix), self._dialect.encoded(prefix))

    def _sources(self, sources: Sequence[str]) -> Condition:
        """Find some sources by their full paths or labels."""
        keys = {key for source in sources for key in source_keys(source, self._roots)}
        paths = {root.name: root.key_folder for root in self._roots}
        encoded, text = self._dialect.encoded, self._dialect.text
        condition = (
            f"coalesce((SELECT name FROM roots WHERE roots.id = root_id), '') = {text} AND key = {text}"
        )
        return _any_source(
            [
                (
                    condition,
                    (
                        encoded(key.root),
                        encoded(path_key(paths[key.root], key.path) if key.root else key.path),
                    ),
                )
                for key in sorted(keys)
            ]
        )


_SOURCES = "SELECT sources.id FROM sources LEFT JOIN roots ON roots.id = root_id"


def _pattern(text: str) -> str:
    escaped = text.translate({ord(character): f"\\{character}" for character in "\\%_"})
    for wildcard, translated in WILDCARDS.items():
        escaped = escaped.replace(wildcard, translated)
    return escaped if any(wildcard in text for wildcard in WILDCARDS) else f"%{escaped}%"


def _literal(text: str) -> str:
    """Remove wildcards."""
    return "".join(character for character in text if character not in WILDCARDS)


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
