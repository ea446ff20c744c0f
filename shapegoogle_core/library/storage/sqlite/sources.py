# SPDX-License-Identifier: MIT
"""SQL of the table `sources`: the files that shapes come from."""

from __future__ import annotations

from shapegoogle_core.library.storage.records import SourceRecord
from shapegoogle_core.library.storage.sqlite.database import Database, encoded

__all__ = ["SourceTable"]


class SourceTable(Database):
    """Sources of a library file."""

    def insert_source(self, source: SourceRecord) -> int:
        """Insert a source, inside `writing`; return its number."""
        error = None if source.error is None else encoded(source.error)
        row = self.connection.execute(
            "INSERT INTO sources (path, size, mtime_ns, sha256, error)"
            " VALUES (CAST(? AS TEXT), ?, ?, ?, CAST(? AS TEXT))",
            (encoded(source.path), source.size, source.mtime_ns, source.sha256, error),
        )
        assert row.lastrowid is not None  # an INSERT that did not raise has made a row
        return row.lastrowid

    def source_id(self, path: str) -> int:
        """Return the number of a source, inside `writing`; make one for an unknown path."""
        content = encoded(path)
        self.connection.execute("INSERT OR IGNORE INTO sources (path) VALUES (CAST(? AS TEXT))", (content,))
        return int(self.value("SELECT id FROM sources WHERE path = CAST(? AS TEXT)", content))

    def update_source(self, path: str, size: int, mtime_ns: int) -> bool:
        """Store the new size and time of change of a source, see `Store.update_source`."""
        with self.writing():
            cursor = self.connection.execute(
                "UPDATE sources SET size = ?, mtime_ns = ? WHERE path = CAST(? AS TEXT)",
                (size, mtime_ns, encoded(path)),
            )
            return cursor.rowcount > 0

    def sources(self) -> list[SourceRecord]:
        """Return all sources, see `Store.sources`."""
        rows = self.rows(
            "SELECT path, size, mtime_ns, sha256, error,"
            " (SELECT count(*) FROM shapes WHERE source_id = sources.id) FROM sources ORDER BY path"
        )
        return [SourceRecord(*row) for row in rows]
