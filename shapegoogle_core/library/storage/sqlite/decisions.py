# SPDX-License-Identifier: MIT
"""SQL of the tables `decisions` and `previews`, which the first change that needs them adds.

A library without them is read as if they were empty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from shapegoogle_core.library.decisions.decision import TAG_KINDS, Decision, ShapeKey
from shapegoogle_core.library.storage.decision_rows import COLUMNS, KEY, SELECT_KEYS, decisions_from
from shapegoogle_core.library.storage.records import SourceKey
from shapegoogle_core.library.storage.sqlite.database import encoded
from shapegoogle_core.library.storage.sqlite.sources import SourceTable

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


class DecisionTable(SourceTable):
    """Decisions about the shapes of a library file, and their previews."""

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

    def decisions(self) -> list[Decision]:
        """Return all decisions, see `Store.decisions`."""
        return self._decisions("")

    def add_decision(self, decision: Decision) -> int:
        """Store a decision, see `Store.add_decision`."""
        with self.writing():
            number = self.insert_decision(replace(decision, number=0))
            if decision.kind in TAG_KINDS:
                self._put_tag(decision, self._shape_of(decision.shape))
        return number

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
                *_key_values(decision.shape),
                *([None] * len(KEY) if decision.other is None else _key_values(decision.other)),
            ),
        ).lastrowid
        assert number is not None  # an INSERT that did not raise has made a row
        return number

    def remove_decision(self, number: int) -> Decision | None:
        """Remove a decision, see `Store.remove_decision`."""
        with self.writing():
            found = self._decisions("WHERE number = ?", number)
            if not found:
                return None
            self.connection.execute("DELETE FROM decisions WHERE number = ?", (number,))
            if found[0].kind in TAG_KINDS:
                self._put_tag(found[0], self._shape_of(found[0].shape), undo=True)
        return found[0]

    def shape_keys(self, shape_ids: Sequence[int]) -> dict[int, ShapeKey]:
        """Return the keys of some shapes, see `Store.shape_keys`."""
        rows = self.rows_with_ids(SELECT_KEYS + "WHERE shapes.id", shape_ids)
        return {shape_id: ShapeKey(*key) for shape_id, *key in rows}

    def shapes_of(self, keys: Sequence[ShapeKey]) -> list[int | None]:
        """Find the shapes that keys name now, see `Store.shapes_of`."""
        return [self._shape_of(key) for key in keys]

    def follow_moves(self, moved: Mapping[SourceKey, SourceKey]) -> None:
        """Change the keys of decisions about shapes of sources that have moved, inside `writing`."""
        if not moved or not self.has_table("decisions"):
            return
        for side in ("shape", "other"):
            rows = self.rows(
                f"SELECT number, {side}_root, {side}_path FROM decisions WHERE {side}_root NOT NULL"
            )
            self.connection.executemany(
                f"UPDATE decisions SET {side}_root = CAST(? AS TEXT), {side}_path = CAST(? AS TEXT)"
                " WHERE number = ?",
                [
                    (encoded(moved[key].root), encoded(moved[key].path), number)
                    for number, *place in rows
                    if (key := SourceKey(*place)) in moved
                ],
            )

    def follow_tag_decisions(self, source: SourceKey, file_hash: str, shape_ids: Sequence[int]) -> None:
        """Give new shapes of a source the tags that were decided for them, inside `writing`."""
        if not self.has_table("decisions"):
            return
        made = self._decisions(
            "WHERE kind IN ('tag', 'no tag')"
            " AND (shape_root = CAST(? AS TEXT) AND shape_path = CAST(? AS TEXT)"
            " OR shape_file_hash != '' AND shape_file_hash = CAST(? AS TEXT))",
            encoded(source.root),
            encoded(source.path),
            encoded(file_hash),
        )
        for decision in made:
            shape_id = self._shape_of(decision.shape)
            if shape_id in shape_ids:
                self._put_tag(decision, shape_id)

    def _decisions(self, where: str, *parameters: object) -> list[Decision]:
        if not self.has_table("decisions"):
            return []
        rows = self.rows(
            f"SELECT number, {', '.join(COLUMNS)} FROM decisions {where} ORDER BY number", *parameters
        )
        return decisions_from(rows)

    def _shape_of(self, key: ShapeKey) -> int | None:
        names = "object_name = CAST(? AS TEXT) AND shapes.name = CAST(? AS TEXT)"
        both = encoded(key.object_name), encoded(key.name)
        if not key.path:
            return self._only(f"SELECT id FROM shapes WHERE source_id IS NULL AND {names}", *both)
        source_id = self.known_source_id(SourceKey(key.root, key.path))
        if source_id is not None:
            found = self._only(f"SELECT id FROM shapes WHERE source_id = ? AND {names}", source_id, *both)
            if found is not None:
                return found
        if not key.file_hash:
            return None
        # The name of a file that is one shape is that of the file, which may have another name now.
        return self._only(
            "SELECT shapes.id FROM shapes JOIN sources ON sources.id = source_id"
            " WHERE sha256 = ? AND object_name = CAST(? AS TEXT)"
            " AND (object_name = '' OR shapes.name = CAST(? AS TEXT))",
            key.file_hash,
            *both,
        )

    def _only(self, statement: str, *parameters: object) -> int | None:
        """Run a query and return its value if there is exactly one row."""
        rows = self.rows(f"{statement} LIMIT 2", *parameters)
        return int(rows[0][0]) if len(rows) == 1 else None

    def _put_tag(self, decision: Decision, shape_id: int | None, *, undo: bool = False) -> None:
        if shape_id is None:
            return
        if (decision.kind == "tag") != undo:
            statement = "INSERT OR IGNORE INTO tags VALUES (?, CAST(? AS TEXT))"
        else:
            statement = "DELETE FROM tags WHERE shape_id = ? AND tag = CAST(? AS TEXT)"
        self.connection.execute(statement, (shape_id, encoded(decision.tag)))


def _key_values(key: ShapeKey) -> tuple[bytes, ...]:
    return tuple(encoded(getattr(key, part)) for part in KEY)
