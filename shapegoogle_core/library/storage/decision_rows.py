# SPDX-License-Identifier: MIT
"""Rows of the table `decisions`: what people have decided about shapes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from shapegoogle_core.library.decisions.decision import Decision, ShapeKey

__all__ = ["COLUMNS", "KEY", "SELECT_KEYS", "decisions_from"]

KEY = ("root", "path", "object_name", "name", "file_hash", "fingerprint")
"""Parts of a `ShapeKey`."""

COLUMNS = (
    "kind",
    "author",
    "time",
    "tag",
    *(f"{side}_{part}" for side in ("shape", "other") for part in KEY),
)
"""Columns of the table behind its number."""

SELECT_KEYS = """
SELECT shapes.id, coalesce(roots.name, ''), coalesce(sources.path, ''), object_name, shapes.name,
    coalesce(sha256, '')
FROM shapes LEFT JOIN sources ON sources.id = source_id LEFT JOIN roots ON roots.id = root_id
"""
"""Selects the ids of shapes and the parts of their keys but the fingerprint."""


def decisions_from(rows: Iterable[Sequence[Any]]) -> list[Decision]:
    """Make decisions of rows.

    Parameters
    ----------
    rows : iterable of sequence
        Number and `COLUMNS`.

    Returns
    -------
    decisions : list of Decision
        In the order of the rows.
    """
    return [
        Decision(
            kind,
            ShapeKey(*keys[: len(KEY)]),
            None if keys[len(KEY)] is None else ShapeKey(*keys[len(KEY) :]),
            tag,
            author,
            time,
            number,
        )
        for number, kind, author, time, tag, *keys in rows
    ]
