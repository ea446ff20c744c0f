# SPDX-License-Identifier: MIT
"""`StoredDecisions`: the table `decisions`, and the tags that follow it, in the SQL of both databases."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from shapegoogle_core.library.decisions.decision import TAG_KINDS, Decision, ShapeKey
from shapegoogle_core.library.storage.decision_rows import COLUMNS, KEY, SELECT_KEYS, decisions_from
from shapegoogle_core.library.storage.records import CopyBatch, SourceKey
from shapegoogle_core.library.storage.stored_rows import StoredRows

__all__ = ["StoredDecisions"]

# Keys of one query: SQLite allows a thousand values in older versions.
_KEYS_AT_ONCE = 100

# For each key the number of shapes that it may mean, and the first of them: by the place of its file, or else
# by the content of a file; the name of a file that is one shape is that of the file, which may have changed.
_SHAPES_OF_KEYS = """
WITH wanted (position, root_id, place, object_name, name, file_hash) AS (VALUES {values})
SELECT position, 0, count(*), min(shapes.id) FROM wanted
    JOIN sources ON coalesce(sources.root_id, 0) = wanted.root_id AND sources.{place} = wanted.place
    JOIN shapes ON source_id = sources.id
        AND shapes.object_name = wanted.object_name AND shapes.name = wanted.name
    GROUP BY position
UNION ALL
SELECT position, 0, count(*), min(shapes.id) FROM wanted
    JOIN shapes ON wanted.place IS NULL AND source_id IS NULL
        AND shapes.object_name = wanted.object_name AND shapes.name = wanted.name
    GROUP BY position
UNION ALL
SELECT position, 1, count(*), min(shapes.id) FROM wanted
    JOIN sources ON wanted.file_hash != '' AND sha256 = wanted.file_hash
    JOIN shapes ON source_id = sources.id AND shapes.object_name = wanted.object_name
        AND (shapes.object_name = '' OR shapes.name = wanted.name)
    GROUP BY position
"""


class StoredDecisions(StoredRows):
    """Decisions about the shapes of a library, and the tags that follow them."""

    place_column: str
    """Column of `sources` that, with the root, identifies a source."""

    wanted_row: str
    """Placeholders of a row of `_SHAPES_OF_KEYS`, with types."""

    # -- what the database provides -------------------------------------------------------------------------

    @abstractmethod
    def located_all(self, sources: Sequence[SourceKey]) -> list[tuple[int, Any]]:
        """Return the values that identify sources."""

    @abstractmethod
    def has_decisions(self) -> bool:
        """Return whether the library has the table."""

    @abstractmethod
    def insert_decision(self, decision: Decision) -> int:
        """Insert a decision, inside `writing`; return its number, the next one if it has none."""

    # -- decisions ------------------------------------------------------------------------------------------

    def decisions(self) -> list[Decision]:
        """Return all decisions, see `Store.decisions`."""
        return self._decisions("")

    def add_decision(self, decision: Decision) -> int:
        """Store a decision, see `Store.add_decision`."""
        with self.writing():
            number = self.insert_decision(replace(decision, number=0))
            if decision.kind in TAG_KINDS:
                (shape_id,) = self.shapes_of([decision.shape])
                if shape_id is not None:
                    self._put_tag(shape_id, decision.tag, has=decision.kind == "tag")
        return number

    def remove_decision(self, number: int) -> Decision | None:
        """Remove a decision, see `Store.remove_decision`."""
        with self.writing():
            found = self._decisions(f"WHERE number = {self.dialect.value}", number)
            if not found:
                return None
            self.delete_decisions([number])
            if found[0].kind in TAG_KINDS:
                self._take_back(found[0])
        return found[0]

    def delete_decisions(self, numbers: Sequence[int]) -> None:
        """Delete decisions, inside `writing`; tags stay as they are."""
        for number in numbers:
            self.execute(f"DELETE FROM decisions WHERE number = {self.dialect.value}", number)

    def shape_keys(self, shape_ids: Sequence[int]) -> dict[int, ShapeKey]:
        """Return the keys of some shapes, see `Store.shape_keys`."""
        rows = self.rows_with_ids(SELECT_KEYS + "WHERE shapes.id", shape_ids)
        return {shape_id: ShapeKey(*key) for shape_id, *key in rows}

    def shapes_of(self, keys: Sequence[ShapeKey]) -> list[int | None]:
        """Find the shapes that keys name now, see `Store.shapes_of`."""
        distinct = list(dict.fromkeys(keys))
        found: dict[ShapeKey, int] = {}
        places = self.located_all([SourceKey(key.root, key.path) for key in distinct])
        for start in range(0, len(distinct), _KEYS_AT_ONCE):
            portion = distinct[start : start + _KEYS_AT_ONCE]
            values = [
                value
                for position, (key, place) in enumerate(zip(portion, places[start:], strict=False))
                for value in self._wanted(position, key, place)
            ]
            statement = _SHAPES_OF_KEYS.format(
                values=", ".join([self.wanted_row] * len(portion)), place=self.place_column
            )
            rows = self.rows(statement, *values)
            for position, _, count, shape_id in sorted(rows, key=lambda row: row[:2]):
                # A key that several shapes fit means none of them.
                if count == 1:
                    found.setdefault(portion[position], int(shape_id))
        return [found.get(key) for key in keys]

    def follow_moves(self, moved: Mapping[SourceKey, SourceKey]) -> None:
        """Change the keys of decisions about shapes of sources that have moved, inside `writing`."""
        if not moved or not self.has_decisions():
            return
        text = self.dialect.text
        for side in ("shape", "other"):
            rows = self.rows(
                f"SELECT number, {side}_root, {side}_path FROM decisions WHERE {side}_root IS NOT NULL"
            )
            for number, *place in rows:
                if (key := SourceKey(*place)) in moved:
                    self.execute(
                        f"UPDATE decisions SET {side}_root = {text}, {side}_path = {text}"
                        f" WHERE number = {self.dialect.value}",
                        *map(self.dialect.encoded, (moved[key].root, moved[key].path)),
                        number,
                    )

    # -- tags -----------------------------------------------------------------------------------------------

    def follow_tag_decisions(self, source: SourceKey, file_hash: str, shape_ids: Sequence[int]) -> None:
        """Give new shapes of a source the tags that were decided for them, inside `writing`."""
        text = self.dialect.text
        made = self._decisions(
            "WHERE kind IN ('tag', 'no tag')"
            f" AND (shape_root = {text} AND shape_path = {text}"
            f" OR shape_file_hash != '' AND shape_file_hash = {text})",
            *map(self.dialect.encoded, (source.root, source.path, file_hash)),
        )
        for decision, shape_id in zip(made, self.shapes_of([one.shape for one in made]), strict=True):
            if shape_id is not None and shape_id in shape_ids:
                self._put_tag(shape_id, decision.tag, has=decision.kind == "tag")

    def put_decisions(self, batch: CopyBatch) -> None:
        """Store the decisions of another library, and the tags that its shapes have, inside `writing`."""
        self.delete_decisions(batch.removed_decisions)
        for decision in batch.decisions:
            self.insert_decision(decision)
        for shape_id, own in batch.tags.items():
            self.execute(f"DELETE FROM tags WHERE shape_id = {self.dialect.value}", shape_id)
            for tag in own:
                self._put_tag(shape_id, tag, has=True)

    def _take_back(self, decision: Decision) -> None:
        """Give the shape of a removed decision the tag as the last decision that is left says."""
        (shape_id,) = self.shapes_of([decision.shape])
        if shape_id is None:
            return
        same_tag = self._decisions(
            f"WHERE kind IN ('tag', 'no tag') AND tag = {self.dialect.text}",
            self.dialect.encoded(decision.tag),
        )
        shapes = self.shapes_of([other.shape for other in same_tag])
        left = [other.kind for other, own in zip(same_tag, shapes, strict=True) if own == shape_id]
        # A tag is given only to a shape without it, so that the first decision tells what was before.
        has = left[-1] == "tag" if left else decision.kind == "no tag"
        self._put_tag(shape_id, decision.tag, has=has)

    def _put_tag(self, shape_id: int, tag: str, *, has: bool) -> None:
        value, text = self.dialect.value, self.dialect.text
        if has:
            statement = f"INSERT INTO tags VALUES ({value}, {text}) ON CONFLICT DO NOTHING"
        else:
            statement = f"DELETE FROM tags WHERE shape_id = {value} AND tag = {text}"
        self.execute(statement, shape_id, self.dialect.encoded(tag))

    def _decisions(self, where: str, *parameters: object) -> list[Decision]:
        if not self.has_decisions():
            return []
        rows = self.rows(
            f"SELECT number, {', '.join(COLUMNS)} FROM decisions {where} ORDER BY number", *parameters
        )
        return decisions_from(rows)

    def _wanted(self, position: int, key: ShapeKey, place: tuple[int, Any]) -> list[object]:
        """Make the values of a row of `_SHAPES_OF_KEYS`."""
        root_id, path = place if key.path else (0, None)
        encoded = self.dialect.encoded
        file_hash = key.file_hash if key.path else ""
        return [position, root_id, path, encoded(key.object_name), encoded(key.name), encoded(file_hash)]

    def key_values(self, key: ShapeKey | None) -> list[object]:
        """Make the values of the columns of a key."""
        return [None if key is None else self.dialect.encoded(getattr(key, part)) for part in KEY]
