# SPDX-License-Identifier: MIT
"""`PostgresqlStore`: a library in a PostgreSQL database."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from psycopg import sql

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.postgresql.codes import CodeTables
from shapegoogle_core.library.storage.postgresql.decisions import DecisionTable
from shapegoogle_core.library.storage.postgresql.kinds import KindTables
from shapegoogle_core.library.storage.postgresql.rows import insert_rows, rows_of_shape
from shapegoogle_core.library.storage.postgresql.schema import FORMAT, schema_statements
from shapegoogle_core.library.storage.postgresql.sources import IS_SOURCE
from shapegoogle_core.library.storage.records import (
    CopyBatch,
    NewShape,
    Rearrangement,
    SourceKey,
    SourceRecord,
    StoreSummary,
)
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["PostgresqlStore"]

_SEQUENCE = "pg_get_serial_sequence('shapes', 'id')"


class PostgresqlStore(CodeTables, KindTables, DecisionTable):
    """A `Store` in a PostgreSQL database. Parameters are those of `Database`."""

    _new_model: tuple[bytes, str] | None = None

    # -- the library as a whole -----------------------------------------------------------------------------

    def is_empty(self) -> bool:
        """Return whether the database has no library in this schema."""
        return self.value("SELECT to_regclass(%s)", f'"{self.address.schema}".meta') is None

    def initialise(self, model: ShapeModel) -> None:
        """Make the tables and store the model, unless another program did so in the meantime.

        Parameters
        ----------
        model : ShapeModel
        """
        with self.writing():
            if not self.is_empty():
                return
            schema = sql.Identifier(self.address.schema)
            # Nothing is created where an administrator has made the schema for this role.
            if self.value("SELECT to_regnamespace(quote_ident(%s))", self.address.schema) is None:
                self.connection.execute(sql.SQL("CREATE SCHEMA {}").format(schema))
            for statement in schema_statements(model):
                self.execute(statement)
            self.execute("INSERT INTO meta VALUES ('schema', %s)", str(FORMAT))
            self.execute("INSERT INTO model VALUES (%s, %s)", model.identifier, model.to_bytes())

    @property
    def read_only(self) -> bool:
        """Whether changes are refused: on request, by the role, or by a server that only follows another."""
        if self._requested_read_only:
            return True
        may = "has_table_privilege('shapes', 'INSERT') AND NOT pg_is_in_recovery()"
        return not self.value(f"SELECT to_regclass('shapes') IS NULL OR {may}")

    def check_format(self) -> None:
        """Make sure that the library is of the current format.

        Raises
        ------
        LibraryError
            If it has another format, or is damaged.
        """
        version = self.value("SELECT value FROM meta WHERE key = 'schema'")
        if not isinstance(version, str) or not version.isdecimal():
            raise self.damaged("it does not say which format it has")
        if int(version) != FORMAT:
            newer = int(version) > FORMAT
            raise LibraryError(
                f"'{self.name}' was made by {'a newer' if newer else 'an older'} version of Shape Google "
                f"(format {version}; this one reads format {FORMAT}); "
                + (
                    "update Shape Google on this computer"
                    if newer
                    else f"run `shapegoogle upgrade '{self.name}'`"
                )
            )

    def model(self) -> tuple[str, bytes]:
        """Return identifier and content of the model, see `Store.model`."""
        rows = self.rows("SELECT identifier, content FROM model")
        if len(rows) != 1:
            raise self.damaged(f"it holds {len(rows)} models instead of one")
        identifier, content = rows[0]
        return identifier, content

    def extend_model(self, identifier: str, content: bytes) -> None:
        """Store a more complete model with the next change, see `Store.extend_model`."""
        self._new_model = (content, identifier)

    def summary(self) -> StoreSummary:
        """Return numbers about the whole library, see `Store.summary`."""
        row = self.rows(
            "SELECT (SELECT count(*) FROM codes), (SELECT count(*) FROM sources),"
            " (SELECT count(error) FROM sources),"
            " (SELECT sum(pg_total_relation_size(oid))::bigint FROM pg_class"
            "  WHERE relnamespace = to_regnamespace(quote_ident(%s)) AND relkind = 'r'),"
            " (SELECT value::integer FROM meta WHERE key = 'schema')",
            self.address.schema,
        )[0]
        return StoreSummary(*row)

    # -- changes --------------------------------------------------------------------------------------------

    def add(self, source: SourceKey | None, shape: NewShape[ShapeSignature]) -> int:
        """Add one shape, see `Store.add`."""
        with self._changing():
            if source is None:
                return self._insert(None, [shape])[0]
            source_id = self.source_id(source)
            self.execute(
                "DELETE FROM shapes WHERE source_id = %s AND object_name = %s AND name = %s",
                *(source_id, shape.object_name, shape.name),
            )
            shape_ids = self._insert(source_id, [shape])
            self.follow_tag_decisions(source, "", shape_ids)
            return shape_ids[0]

    def replace_source(
        self,
        source: SourceRecord,
        shapes: Iterable[NewShape[ShapeSignature]],
        *,
        also: SourceKey | None = None,
        claim: bool = False,
    ) -> list[int]:
        """Store a source and its shapes in place of the earlier ones, see `Store.replace_source`."""
        listed = list(shapes)
        with self._changing():
            if claim and (stored := self.claimed(source)) is not None:
                return stored
            self._remove_source(source.key)
            if also is not None:
                self._remove_source(also)
            shape_ids = self._insert(self.insert_source(source), listed)
            self.follow_tag_decisions(source.key, source.sha256 or "", shape_ids)
            return shape_ids

    def remove_sources(self, sources: Iterable[SourceKey]) -> int:
        """Remove sources with all their shapes, see `Store.remove_sources`."""
        with self._changing():
            return sum(self._remove_source(source) for source in sources)

    def rearrange(self, changes: Rearrangement) -> None:
        """Change roots and the places of sources, see `Store.rearrange`."""
        with self._changing():
            for source in changes.removed:
                self._remove_source(source)
            moved = [(self.known_source_id(old), new) for old, new in changes.moved]
            for name, path in changes.roots:
                self.put_root(name, path)
            self.put_sources([(number, new) for number, new in moved if number is not None])
            self.follow_moves(dict(changes.moved))
            for name in changes.removed_roots:
                self.execute("DELETE FROM roots WHERE name = %s", name)

    def remove_shapes(self, shape_ids: Iterable[int]) -> int:
        """Remove single shapes, see `Store.remove_shapes`."""
        with self._changing():
            return self.execute("DELETE FROM shapes WHERE id = ANY(%s::bigint[])", list(shape_ids))

    @contextmanager
    def _changing(self) -> Iterator[None]:
        """Run changes as one transaction, which first stores the parts that the model lacks."""
        with self.writing():
            if self._new_model is not None:
                self.execute("UPDATE model SET content = %s WHERE identifier = %s", *self._new_model)
            yield
        self._new_model = None

    # -- copies of other libraries --------------------------------------------------------------------------

    def last_id(self) -> int:
        """Return the greatest number that was ever given, see `Store.last_id`."""
        return self.value(f"SELECT pg_sequence_last_value({_SEQUENCE}::regclass)") or 0

    def copy_mark(self) -> str | None:
        """Return the mark of an unfinished copy, see `Store.copy_mark`."""
        mark: str | None = self.value("SELECT value FROM meta WHERE key = 'copy'")
        return mark

    def put_copy(self, batch: CopyBatch) -> None:
        """Store a part of another library, see `Store.put_copy`."""
        with self._changing():
            for source in batch.removed_sources:
                self._remove_source(source)
            for name, path in batch.roots:
                self.put_root(name, path)
            for record in batch.sources:
                self.put_source(record)
            keys = {key for _, key, _ in batch.shapes if key is not None}
            source_ids: dict[SourceKey | None, int | None] = {key: self.source_id(key) for key in keys}
            insert_rows(
                self.connection,
                (
                    row
                    for number, key, shape in batch.shapes
                    for row in rows_of_shape(number, source_ids.get(key), shape)
                ),
            )
            self.insert_neighbours(batch.neighbours)
            self.put_decisions(batch)
            if batch.last_id > self.last_id():
                self.value(f"SELECT setval({_SEQUENCE}, %s)", batch.last_id)
            self.execute("DELETE FROM meta WHERE key = 'copy'")
            if batch.mark is not None:
                self.execute("INSERT INTO meta VALUES ('copy', %s)", batch.mark)

    def _insert(self, source_id: int | None, shapes: Sequence[NewShape[ShapeSignature]]) -> list[int]:
        """Insert new shapes; the sequence gives no number twice, not even those of an undone transaction."""
        rows = self.rows(f"SELECT nextval({_SEQUENCE}) FROM generate_series(1, %s)", len(shapes))
        numbers = sorted(number for (number,) in rows)
        insert_rows(
            self.connection,
            (
                row
                for number, shape in zip(numbers, shapes, strict=True)
                for row in rows_of_shape(number, source_id, shape)
            ),
        )
        return numbers

    def _remove_source(self, source: SourceKey) -> int:
        """Remove a source; its shapes and the rows of all other tables go with it."""
        return self.execute(f"DELETE FROM sources WHERE {IS_SOURCE}", *self.located(source))
