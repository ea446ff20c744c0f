# SPDX-License-Identifier: MIT
"""SQL of the tables `decisions` and `previews` that is PostgreSQL's own."""

from __future__ import annotations

from shapegoogle_core.library.decisions.decision import Decision
from shapegoogle_core.library.storage.decision_rows import COLUMNS
from shapegoogle_core.library.storage.postgresql.sources import SourceTable
from shapegoogle_core.library.storage.stored_decisions import StoredDecisions

__all__ = ["DecisionTable"]

_SEQUENCE = "pg_get_serial_sequence('decisions', 'number')"


class DecisionTable(SourceTable, StoredDecisions):
    """Decisions about the shapes of a library in a database, and their previews."""

    place_column = "key_hash"
    wanted_row = '(%s::integer, %s::integer, %s::bytea, %s::text COLLATE "C", %s::text COLLATE "C", %s::text)'

    def preview(self, shape_id: int) -> bytes | None:
        """Return the small mesh of a shape, see `Store.preview`."""
        preview: bytes | None = self.value("SELECT content FROM previews WHERE shape_id = %s", shape_id)
        return preview

    def has_decisions(self) -> bool:
        """Return whether the library has the table; a database has all tables."""
        return True

    def insert_decision(self, decision: Decision) -> int:
        """Insert a decision, inside `writing`; return its number, the next one if it has none."""
        number: int = decision.number
        if number:
            self.value(f"SELECT setval({_SEQUENCE}, greatest(%s, nextval({_SEQUENCE})))", number)
        else:
            number = self.value(f"SELECT nextval({_SEQUENCE})")
        self.execute(
            f"INSERT INTO decisions (number, {', '.join(COLUMNS)})"
            f" VALUES (%s, {', '.join(['%s'] * len(COLUMNS))})",
            *(number, decision.kind, decision.author, decision.time, decision.tag),
            *self.key_values(decision.shape),
            *self.key_values(decision.other),
        )
        return number
