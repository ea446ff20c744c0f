# SPDX-License-Identifier: MIT
"""SQL of the tables `roots` and `sources`: the files that shapes come from, and their folders."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from shapegoogle_core.library.roots.paths import joined
from shapegoogle_core.library.storage.filter_conditions import folded
from shapegoogle_core.library.storage.postgresql.database import Database
from shapegoogle_core.library.storage.postgresql.dialect import DIALECT
from shapegoogle_core.library.storage.records import SourceKey, SourceRecord
from shapegoogle_core.library.storage.stored_rows import StoredRows

__all__ = ["IS_SOURCE", "SourceTable"]

Located = tuple[int, bytes]
"""Number of the root of a source, 0 for a label; and the hash of the key of its path."""

IS_SOURCE = "coalesce(root_id, 0) = %s AND key_hash = %s"


class SourceTable(Database, StoredRows):
    """Roots and sources of a library in a database."""

    dialect = DIALECT

    # -- roots ----------------------------------------------------------------------------------------------

    def located(self, source: SourceKey) -> Located:
        """Return the values of the columns that identify a source."""
        return self.located_all([source])[0]

    def located_all(self, sources: Sequence[SourceKey]) -> list[Located]:
        """Return the values of the columns that identify sources; no source lies below an unknown root."""
        return [(number, _hash(key)) for number, key in self.places(sources)]

    def put_root(self, name: str, path: str) -> None:
        """Insert a root, or change its path, inside `writing`."""
        self.execute(
            "INSERT INTO roots (name, path, folded) VALUES (%s, %s, %s)"
            " ON CONFLICT (name) DO UPDATE SET path = excluded.path, folded = excluded.folded",
            *(name, path, folded(path)),
        )

    def put_sources(self, places: Sequence[tuple[int, SourceKey]]) -> None:
        """Change the keys of sources, by their numbers, inside `writing`."""
        # Two sources may exchange their places, so all leave theirs before the first takes its new one.
        numbers = [number for number, _ in places]
        self.execute(
            "UPDATE sources SET root_id = NULL, key_hash = int8send(id) WHERE id = ANY(%s::bigint[])", numbers
        )
        for number, source in places:
            ((root_id, key),) = self.places([source])
            self.execute(
                "UPDATE sources SET root_id = nullif(%s, 0), path = %s, key = %s, key_hash = %s, folded = %s"
                " WHERE id = %s",
                *(root_id, source.path, key, _hash(key), folded(source.path), number),
            )

    # -- sources --------------------------------------------------------------------------------------------

    def insert_source(self, source: SourceRecord) -> int:
        """Insert a source, inside `writing`; return its number."""
        ((root_id, key),) = self.places([source.key])
        path = source.key.path
        number: int = self.value(
            "INSERT INTO sources (root_id, path, key, key_hash, folded, size, mtime_ns, sha256, error)"
            " VALUES (nullif(%s, 0), %s, %s, %s, %s, %s, %s, %s, %s) RETURNING id",
            *(root_id, path, key, _hash(key), folded(path)),
            *(source.size, source.mtime_ns, source.sha256, source.error),
        )
        return number

    def claimed(self, source: SourceRecord) -> list[int] | None:
        """Return the shapes of a source that is stored with the same content, inside `writing`."""
        number = self.known_source_id(source.key)
        same = "SELECT 1 FROM sources WHERE id = %s AND sha256 = %s AND error IS NULL"
        if number is None or source.error is not None or self.value(same, number, source.sha256) is None:
            return None
        rows = self.rows("SELECT id FROM shapes WHERE source_id = %s ORDER BY id", number)
        return [row[0] for row in rows]

    def put_source(self, source: SourceRecord) -> None:
        """Insert a source, or change its record, inside `writing`; its shapes stay."""
        number = self.known_source_id(source.key)
        if number is None:
            self.insert_source(source)
            return
        self.execute(
            "UPDATE sources SET size = %s, mtime_ns = %s, sha256 = %s, error = %s WHERE id = %s",
            *(source.size, source.mtime_ns, source.sha256, source.error, number),
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
        located = dict(zip(keys, self.located_all(keys), strict=True))
        found = set(
            self.rows(
                "SELECT coalesce(root_id, 0), key_hash FROM sources WHERE (coalesce(root_id, 0), key_hash) IN"
                " (SELECT * FROM unnest(%s::integer[], %s::bytea[]))",
                [root for root, _ in located.values()],
                [key for _, key in located.values()],
            )
        )
        return [key for key in keys if located[key] in found]

    def update_source(self, source: SourceKey, size: int, mtime_ns: int) -> bool:
        """Store the new size and time of change of a source, see `Store.update_source`."""
        with self.writing():
            return (
                self.execute(
                    f"UPDATE sources SET size = %s, mtime_ns = %s WHERE {IS_SOURCE}",
                    *(size, mtime_ns, *self.located(source)),
                )
                > 0
            )

    def sources(self) -> list[SourceRecord]:
        """Return all sources, see `Store.sources`."""
        rows = self.rows(
            "SELECT sources.path, size, mtime_ns, sha256, error, coalesce(number, 0), roots.name, roots.path"
            " FROM sources LEFT JOIN roots ON roots.id = root_id LEFT JOIN (SELECT source_id,"
            " count(*) AS number FROM shapes GROUP BY source_id) AS counts ON source_id = sources.id"
        )
        records = []
        for path, size, mtime_ns, sha256, error, shapes, root, folder in rows:
            place = (
                (path, "", "") if root is None else (joined(self.local_folders.of(folder), path), root, path)
            )
            records.append(SourceRecord(place[0], size, mtime_ns, sha256, error, shapes, *place[1:]))
        return sorted(records, key=lambda record: record.path)


def _hash(key: str) -> bytes:
    return hashlib.sha256(key.encode("utf-8", "surrogatepass")).digest()
