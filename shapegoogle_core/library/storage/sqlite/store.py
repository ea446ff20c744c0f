# SPDX-License-Identifier: MIT
"""`SqliteStore`: a library in one SQLite file."""

from __future__ import annotations

from collections.abc import Iterable

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.records import (
    CopyBatch,
    NewShape,
    Rearrangement,
    SourceKey,
    SourceRecord,
    StoreSummary,
)
from shapegoogle_core.library.storage.sqlite.bags import BagTable
from shapegoogle_core.library.storage.sqlite.codes import CodeTables
from shapegoogle_core.library.storage.sqlite.database import encoded
from shapegoogle_core.library.storage.sqlite.decisions import DecisionTable
from shapegoogle_core.library.storage.sqlite.schema import (
    APPLICATION_ID,
    EARLIER_FORMAT,
    FORMAT,
    SCHEMA,
    SCHEMA_OF_KINDS,
)
from shapegoogle_core.library.storage.sqlite.shapes import ShapeTable
from shapegoogle_core.library.storage.sqlite.sources import IS_SOURCE
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["SqliteStore"]


class SqliteStore(CodeTables, BagTable, ShapeTable, DecisionTable):
    """A `Store` in one SQLite file. Parameters are those of `CodeTables`."""

    # -- the file as a whole --------------------------------------------------------------------------------

    def is_empty(self) -> bool:
        """Return whether nothing was ever committed: the file is new, or making it was interrupted."""
        tables = self.value("SELECT count(*) FROM sqlite_master")
        return bool(tables == 0 and self.value("PRAGMA application_id") == 0)

    def initialise(self, model: ShapeModel) -> None:
        """Make the tables and store the model, unless another program did so in the meantime.

        Parameters
        ----------
        model : ShapeModel
        """
        with self.writing():
            if not self.is_empty():
                return
            self.connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            for statement in (SCHEMA + SCHEMA_OF_KINDS).format(block_ids=self.block_ids).split(";\n"):
                self.connection.execute(statement)
            self.connection.execute("INSERT INTO meta VALUES ('schema', ?)", (str(FORMAT),))
            self.connection.execute("INSERT INTO model VALUES (?, ?)", (model.identifier, model.to_bytes()))

    def check_format(self) -> None:
        """Make sure that the file is a library of the current format, or of the one before.

        Raises
        ------
        LibraryError
            If the file is something else, damaged, or of any other format.
        """
        if self.value("PRAGMA application_id") != APPLICATION_ID:
            raise LibraryError(
                "'{path}' is an SQLite database of another program, not a Shape Google library; choose "
                "another file",
                path=self.path,
            )
        version = self.value("SELECT value FROM meta WHERE key = 'schema'")
        if not isinstance(version, str) or not version.isdecimal():
            raise self.damaged("it does not say which format it has")
        if int(version) not in (EARLIER_FORMAT, FORMAT):
            formats = {"path": self.path, "version": version, "earlier": EARLIER_FORMAT, "latest": FORMAT}
            if int(version) > FORMAT:
                raise LibraryError(
                    "'{path}' was made by a newer version of Shape Google (format {version}; this one reads "
                    "formats {earlier} and {latest}); update Shape Google, or index your folders into a new "
                    "library",
                    **formats,
                )
            raise LibraryError(
                "'{path}' was made by an older version of Shape Google (format {version}; this one reads "
                "formats {earlier} and {latest}); index your folders into a new library",
                **formats,
            )

    def model(self) -> tuple[str, bytes]:
        """Return identifier and content of the model, see `Store.model`."""
        rows = self.rows("SELECT identifier, content FROM model")
        if len(rows) != 1:
            raise self.damaged(f"it holds {len(rows)} models instead of one")
        return rows[0]

    def summary(self) -> StoreSummary:
        """Return numbers about the whole library, see `Store.summary`."""
        row = self.rows(
            "SELECT (SELECT count(*) FROM codes), (SELECT count(*) FROM sources),"
            " (SELECT count(error) FROM sources),"
            " (SELECT page_count * page_size FROM pragma_page_count, pragma_page_size),"
            " (SELECT CAST(value AS INTEGER) FROM meta WHERE key = 'schema')"
        )[0]
        return StoreSummary(*row)

    # -- changes --------------------------------------------------------------------------------------------

    def add(self, source: SourceKey | None, shape: NewShape[ShapeSignature]) -> int:
        """Add one shape, see `Store.add`."""
        with self.writing():
            if source is None:
                return self._insert(None, shape)
            source_id = self.source_id(source)
            self._remove(
                "source_id = ? AND object_name = CAST(? AS TEXT) AND name = CAST(? AS TEXT)",
                (source_id, encoded(shape.object_name), encoded(shape.name)),
            )
            shape_id = self._insert(source_id, shape)
            self.follow_tag_decisions(source, "", [shape_id])
            return shape_id

    def replace_source(
        self,
        source: SourceRecord,
        shapes: Iterable[NewShape[ShapeSignature]],
        *,
        also: SourceKey | None = None,
        claim: bool = False,
    ) -> list[int]:
        """Store a source and its shapes in place of the earlier ones, see `Store.replace_source`."""
        with self.writing():
            if claim and (stored := self.claimed(source)) is not None:
                return stored
            self._remove_source(source.key)
            if also is not None:
                self._remove_source(also)
            source_id = self.insert_source(source)
            shape_ids = [self._insert(source_id, shape) for shape in shapes]
            self.follow_tag_decisions(source.key, source.sha256 or "", shape_ids)
            return shape_ids

    def remove_sources(self, sources: Iterable[SourceKey]) -> int:
        """Remove sources with all their shapes, see `Store.remove_sources`."""
        with self.writing():
            return sum(self._remove_source(source) for source in sources)

    def rearrange(self, changes: Rearrangement) -> None:
        """Change roots and the places of sources, see `Store.rearrange`."""
        with self.writing():
            for source in changes.removed:
                self._remove_source(source)
            moved = [(self.known_source_id(old), new) for old, new in changes.moved]
            for name, path in changes.roots:
                self.put_root(name, path)
            self.put_sources([(number, new) for number, new in moved if number is not None])
            self.follow_moves(dict(changes.moved))
            for name in changes.removed_roots:
                self.connection.execute("DELETE FROM roots WHERE name = CAST(? AS TEXT)", (encoded(name),))

    def remove_shapes(self, shape_ids: Iterable[int]) -> int:
        """Remove single shapes, see `Store.remove_shapes`."""
        with self.writing():
            return sum(self._remove("id = ?", (shape_id,)) for shape_id in shape_ids)

    # -- copies of other libraries --------------------------------------------------------------------------

    def last_id(self) -> int:
        """Return the greatest number that was ever given, see `Store.last_id`."""
        return self.value("SELECT seq FROM sqlite_sequence WHERE name = 'shapes'") or 0

    def copy_mark(self) -> str | None:
        """Return the mark of an unfinished copy, see `Store.copy_mark`."""
        mark: str | None = self.value("SELECT value FROM meta WHERE key = 'copy'")
        return mark

    def put_copy(self, batch: CopyBatch) -> None:
        """Store a part of another library, see `Store.put_copy`."""
        with self.writing():
            for source in batch.removed_sources:
                self._remove_source(source)
            for name, path in batch.roots:
                self.put_root(name, path)
            for record in batch.sources:
                self.put_source(record)
            for number, key, shape in batch.shapes:
                self._insert(None if key is None else self.source_id(key), shape, number)
            self.insert_neighbours(batch.neighbours)
            self.put_decisions(batch)
            if batch.last_id > self.last_id():
                self.connection.execute("DELETE FROM sqlite_sequence WHERE name = 'shapes'")
                self.connection.execute("INSERT INTO sqlite_sequence VALUES ('shapes', ?)", (batch.last_id,))
            self.connection.execute("DELETE FROM meta WHERE key = 'copy'")
            if batch.mark is not None:
                self.connection.execute(
                    "INSERT INTO meta VALUES ('copy', CAST(? AS TEXT))", (encoded(batch.mark),)
                )

    def _insert(
        self, source_id: int | None, shape: NewShape[ShapeSignature], number: int | None = None
    ) -> int:
        shape_id = self.insert_record(source_id, shape, number)
        self.insert_bags(shape_id, shape.signature.bags)
        self.insert_codes(shape_id, shape.signature)
        self.insert_kind(shape_id, shape.signature)
        if shape.preview is not None:
            self.insert_preview(shape_id, shape.preview)
        return shape_id

    def _remove(self, where: str, parameters: tuple[object, ...]) -> int:
        """Remove shapes; the rows of all other tables go with that of `shapes`."""
        self.note_removal(where, parameters)
        return self.connection.execute(f"DELETE FROM shapes WHERE {where}", parameters).rowcount

    def _remove_source(self, source: SourceKey) -> int:
        located = self.located(source)
        self._remove(f"source_id = (SELECT id FROM sources WHERE {IS_SOURCE})", located)
        return self.connection.execute(f"DELETE FROM sources WHERE {IS_SOURCE}", located).rowcount
