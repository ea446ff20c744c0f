# SPDX-License-Identifier: MIT
"""SQL of the tables `decisions` and `previews`, which the first change that needs them adds.

A library without them is read as if they were empty.
"""

from __future__ import annotations

from shapegoogle_core.library.decisions.decision import Decision
from shapegoogle_core.library.storage.decision_rows import COLUMNS, KEY
from shapegoogle_core.library.storage.sqlite.database import encoded
from shapegoogle_core.library.storage.sqlite.sources import SourceTable
from shapegoogle_core.library.storage.stored_decisions import StoredDecisions

__all__ = ["DecisionTable"]

_SCHEMA_OF_DECISIONS = f"""
CREATE TABLE IF NOT EXISTS decisions (
    number INTEGER PRIMARY KEY AUTOINCREMENT, -- a number that was shown must never mean another decision
    kind TEXT NOT NULL,
    author TEXT NOT NULL,
    time REAL NOT NULL,
    tag TEXT NOT NULL,
    {", ".join(f"shape_{part} TEXT NOT NULL" for part in KEY)},
    {", ".join(f"other_{part} TEXT" for part in KEY)} -- NULL: the decision is about one shape
)
"""
_SCHEMA_OF_PREVIEWS = """
CREATE TABLE IF NOT EXISTS previews (
    shape_id INTEGER PRIMARY KEY REFERENCES shapes (id) ON DELETE CASCADE,
    content BLOB NOT NULL
)
"""


class DecisionTable(SourceTable, StoredDecisions):
    """Decisions about the shapes of a library file, and their previews."""

    place_column = "key"
    wanted_row = "(?, ?, CAST(? AS TEXT), CAST(? AS TEXT), CAST(? AS TEXT), CAST(? AS TEXT))"

    def has_table(self, name: str) -> bool:
        """Return whether the file has a table."""
        return self.value("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?", name) is not None

    # -- previews -------------------------------------------------------------------------------------------

    def insert_preview(self, shape_id: int, preview: bytes) -> None:
        """Insert the preview of a new shape, inside `writing`."""
        self.connection.execute(_SCHEMA_OF_PREVIEWS)
        self.connection.execute("INSERT INTO previews VALUES (?, ?)", (shape_id, preview))

    def preview(self, shape_id: int) -> bytes | None:
        """Return the small mesh of a shape, see `Store.preview`."""
        if not self.has_table("previews"):
            return None
        preview: bytes | None = self.value("SELECT content FROM previews WHERE shape_id = ?", shape_id)
        return preview

    # -- decisions ------------------------------------------------------------------------------------------

    def has_decisions(self) -> bool:
        """Return whether the file has the table."""
        return self.has_table("decisions")

    def insert_decision(self, decision: Decision) -> int:
        """Insert a decision, inside `writing`; return its number, the next one if it has none."""
        marks = ", ".join("CAST(? AS TEXT)" if column != "time" else "?" for column in COLUMNS)
        self.connection.execute(_SCHEMA_OF_DECISIONS)
        number = self.connection.execute(
            f"INSERT INTO decisions (number, {', '.join(COLUMNS)}) VALUES (?, {marks})",
            (
                decision.number or None,
                encoded(decision.kind),
                encoded(decision.author),
                decision.time,
                encoded(decision.tag),
                *self.key_values(decision.shape),
                *self.key_values(decision.other),
            ),
        ).lastrowid
        assert number is not None  # an INSERT that did not raise has made a row
        return number
