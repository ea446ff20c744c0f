# SPDX-License-Identifier: MIT
"""SQL of the tables `decisions` and `previews`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from shapegoogle_core.library.decisions.decision import TAG_KINDS, Decision, ShapeKey
from shapegoogle_core.library.storage.decision_rows import COLUMNS, KEY, SELECT_KEYS, decisions_from
from shapegoogle_core.library.storage.postgresql.sources import SourceTable
from shapegoogle_core.library.storage.records import SourceKey

__all__ = ["DecisionTable"]

_SEQUENCE = "pg_get_serial_sequence('decisions', 'number')"


class DecisionTable(SourceTable):
    """Decisions about the shapes of a library in a database, and their previews."""

    def preview(self, shape_id: int) -> bytes | None:
        """Return the small mesh of a shape, see `Store.preview`."""
        preview: bytes | None = self.value("SELECT content FROM previews WHERE shape_id = %s", shape_id)
        return preview

    # -- decisions ------------------------------------------------------------------------------------------

    def decisions(self) -> list[Decision]:
        """Return all decisions, see `Store.decisions`."""
        return self._decisions("")

    def add_decision(self, decision: Decision) -> int:
        """Store a decision, see `Store.add_decision`."""
        with self.writing():
            number = self.insert_decision(decision)
            if decision.kind in TAG_KINDS:
                self._put_tag(decision, self._shape_of(decision.shape))
        return number

    def insert_decision(self, decision: Decision, *, numbered: bool = False) -> int:
        """Insert a decision, inside `writing`; return its number: its own, or else the next one."""
        number: int = decision.number
        if numbered:
            self.value(f"SELECT setval({_SEQUENCE}, greatest(%s, nextval({_SEQUENCE})))", number)
        else:
            number = self.value(f"SELECT nextval({_SEQUENCE})")
        self.execute(
            f"INSERT INTO decisions (number, {', '.join(COLUMNS)})"
            f" VALUES (%s, {', '.join(['%s'] * len(COLUMNS))})",
            *(number, decision.kind, decision.author, decision.time, decision.tag),
            *_key_values(decision.shape),
            *([None] * len(KEY) if decision.other is None else _key_values(decision.other)),
        )
        return number

    def remove_decision(self, number: int) -> Decision | None:
        """Remove a decision, see `Store.remove_decision`."""
        with self.writing():
            found = self._decisions("WHERE number = %s", number)
            if not found:
                return None
            self.execute("DELETE FROM decisions WHERE number = %s", number)
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
        if not moved:
            return
        for side in ("shape", "other"):
            rows = self.rows(
                f"SELECT number, {side}_root, {side}_path FROM decisions WHERE {side}_root IS NOT NULL"
            )
            for number, *place in rows:
                if (key := SourceKey(*place)) in moved:
                    self.execute(
                        f"UPDATE decisions SET {side}_root = %s, {side}_path = %s WHERE number = %s",
                        *(moved[key].root, moved[key].path, number),
                    )

    def follow_tag_decisions(self, source: SourceKey, file_hash: str, shape_ids: Sequence[int]) -> None:
        """Give new shapes of a source the tags that were decided for them, inside `writing`."""
        made = self._decisions(
            "WHERE kind IN ('tag', 'no tag')"
            " AND (shape_root = %s AND shape_path = %s"
            " OR shape_file_hash != '' AND shape_file_hash = %s)",
            source.root,
            source.path,
            file_hash,
        )
        for decision in made:
            shape_id = self._shape_of(decision.shape)
            if shape_id in shape_ids:
                self._put_tag(decision, shape_id)

    def _decisions(self, where: str, *parameters: object) -> list[Decision]:
        rows = self.rows(
            f"SELECT number, {', '.join(COLUMNS)} FROM decisions {where} ORDER BY number", *parameters
        )
        return decisions_from(rows)

    def _shape_of(self, key: ShapeKey) -> int | None:
        names = "object_name = %s AND shapes.name = %s"
        both = key.object_name, key.name
        if not key.path:
            return self._only(f"SELECT id FROM shapes WHERE source_id IS NULL AND {names}", *both)
        source_id = self.known_source_id(SourceKey(key.root, key.path))
        if source_id is not None:
            found = self._only(f"SELECT id FROM shapes WHERE source_id = %s AND {names}", source_id, *both)
            if found is not None:
                return found
        if not key.file_hash:
            return None
        # The name of a file that is one shape is that of the file, which may have another name now.
        return self._only(
            "SELECT shapes.id FROM shapes JOIN sources ON sources.id = source_id"
            " WHERE sha256 = %s AND object_name = %s"
            " AND (object_name = '' OR shapes.name = %s)",
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
            statement = "INSERT INTO tags VALUES (%s, %s) ON CONFLICT DO NOTHING"
        else:
            statement = "DELETE FROM tags WHERE shape_id = %s AND tag = %s"
        self.execute(statement, shape_id, decision.tag)


def _key_values(key: ShapeKey) -> tuple[str, ...]:
    return tuple(getattr(key, part) for part in KEY)
