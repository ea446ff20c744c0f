# SPDX-License-Identifier: MIT
"""SQL of the tables `roots` and `sources`: the files that shapes come from, and their folders."""

from __future__ import annotations

from collections.abc import Sequence

from shapegoogle_core.library.roots.paths import joined
from shapegoogle_core.library.storage.records import SourceKey, SourceRecord
from shapegoogle_core.library.storage.sqlite.database import Database, encoded
from shapegoogle_core.library.storage.sqlite.dialect import DIALECT
from shapegoogle_core.library.storage.stored_rows import StoredRows

__all__ = ["IS_SOURCE", "SourceTable"]

Located = tuple[int, bytes]
"""Number of the root of a source, 0 for a label; and the key of its path."""

IS_SOURCE = "coalesce(root_id, 0) = ? AND key = CAST(? AS TEXT)"


class SourceTable(Database, StoredRows):
    """Roots and sources of a library file."""

    dialect = DIALECT

    # -- roots ----------------------------------------------------------------------------------------------

    def located(self, source: SourceKey) -> Located:
        """Return the values of the columns that identify a source."""
        return self.located_all([source])[0]

    def located_all(self, sources: Sequence[SourceKey]) -> list[Located]:
        """Return the values of the columns that identify sources; no source lies below an unknown root."""
        return [(number, encoded(key)) for number, key in self.places(sources)]

    def put_root(self, name: str, path: str) -> None:
        """Insert a root, or change its path, inside `writing`."""
        self.connection.execute(
            "INSERT INTO roots (name, path) VALUES (CAST(? AS TEXT), CAST(? AS TEXT))"
            " ON CONFLICT (name) DO UPDATE SET path = excluded.path",
            (encoded(name), encoded(path)),
        )

    def put_sources(self, places: Sequence[tuple[int, SourceKey]]) -> None:
        """Change the keys of sources, by their numbers, inside `writing`."""
        # Two sources may exchange their places, so all leave theirs before the first takes its new one.
        self.connection.executemany(
            "UPDATE sources SET root_id = NULL, key = char(0) || id WHERE id = ?",
            [(number,) for number, _ in places],
        )
        for number, source in places:
            root_id, key = self.located(source)
            self.connection.execute(
                "UPDATE sources SET root_id = nullif(?, 0), path = CAST(? AS TEXT), key = CAST(? AS TEXT)"
                " WHERE id = ?",
                (root_id, encoded(source.path), key, number),
            )

    # -- sources --------------------------------------------------------------------------------------------

    def insert_source(self, source: SourceRecord) -> int:
        """Insert a source, inside `writing`; return its number."""
        error = None if source.error is None else encoded(source.error)
        root_id, key = self.located(source.key)
        row = self.connection.execute(
            "INSERT INTO sources (root_id, path, key, size, mtime_ns, sha256, error)"
            " VALUES (nullif(?, 0), CAST(? AS TEXT), CAST(? AS TEXT), ?, ?, ?, CAST(? AS TEXT))",
            (root_id, encoded(source.key.path), key, source.size, source.mtime_ns, source.sha256, error),
        )
        assert row.lastrowid is not None  # an INSERT that did not raise has made a row
        return row.lastrowid

    def claimed(self, source: SourceRecord) -> list[int] | None:
        """Return the shapes of a source that is stored with the same content, inside `writing`."""
        number = self.known_source_id(source.key)
        same = "SELECT 1 FROM sources WHERE id = ? AND sha256 = ? AND error IS NULL"
        if number is None or source.error is not None or self.value(same, number, source.sha256) is None:
            return None
        rows = self.rows("SELECT id FROM shapes WHERE source_id = ? ORDER BY id", number)
        return [row[0] for row in rows]

    def put_source(self, source: SourceRecord) -> None:
        """Insert a source, or change its record, inside `writing`; its shapes stay."""
        number = self.known_source_id(source.key)
        if number is None:
            self.insert_source(source)
            return
        error = None if source.error is None else encoded(source.error)
        self.connection.execute(
            "UPDATE sources SET size = ?, mtime_ns = ?, sha256 = ?, error = CAST(? AS TEXT) WHERE id = ?",
            (source.size, source.mtime_ns, source.sha256, error, number),
        )

    def source_id(self, source: SourceKey) -> int:
        """Return the number of a source, inside `writing`; make one for an unknown key."""
        known = self.known_source_id(source)
        if known is not None:
            return known
        return self.insert_source(SourceRecord.of(source))

    def known_source_id(self, source: SourceKey) -> int | None:
        """Return the number of a source, None if it is unknown."""
        number: int | None = self.value(f"SELECT id FROM sources WHERE {IS_SOURCE}", *self.located(source))
        return number

    def known_sources(self, keys: Sequence[SourceKey]) -> list[SourceKey]:
        """Return those of some keys that are sources, see `Store.known_sources`."""
        return [key for key in keys if self.known_source_id(key) is not None]

    def update_source(self, source: SourceKey, size: int, mtime_ns: int) -> bool:
        """Store the new size and time of change of a source, see `Store.update_source`."""
        with self.writing():
            cursor = self.connection.execute(
                f"UPDATE sources SET size = ?, mtime_ns = ? WHERE {IS_SOURCE}",
                (size, mtime_ns, *self.located(source)),
            )
            return cursor.rowcount > 0

    def sources(self) -> list[SourceRecord]:
        """Return all sources, see `Store.sources`."""
        rows = self.rows(
            "SELECT sources.path, size, mtime_ns, sha256, error,"
            " (SELECT count(*) FROM shapes WHERE source_id = sources.id), roots.name, roots.path"
            " FROM sources LEFT JOIN roots ON roots.id = root_id"
        )
        records = []
        for path, size, mtime_ns, sha256, error, shapes, root, folder in rows:
            place = (
                (path, "", "") if root is None else (joined(self.local_folders.of(folder), path), root, path)
            )
            records.append(SourceRecord(place[0], size, mtime_ns, sha256, error, shapes, *place[1:]))
        return sorted(records, key=lambda record: record.path)
