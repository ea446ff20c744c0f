# SPDX-License-Identifier: MIT
"""What a user interface shows of a library: its size and model, and which of the shapes it still has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import ShapeRecord

__all__ = ["LibraryState", "ShownShape", "state_of"]


@dataclass(frozen=True)
class ShownShape:
    """A shape of a library as it is shown.

    Attributes
    ----------
    shape_id : int
    source, name : str
        As when it was found.
    """

    shape_id: int
    source: str
    name: str


@dataclass(frozen=True)
class LibraryState:
    """A library at this moment.

    Attributes
    ----------
    path : Path
        As it was asked for.
    shape_count : int
    model : str
        Name of its model; empty if there is no library.
    today : dict of int to int or None
        For the number of each shape asked for its number now: another one if its file was indexed again, None
        if it is not in the library any more.
    without_views : int
        Number of shapes that an earlier version has described without views: the search for more of the same
        kind does not find them.
    """

    path: Path
    shape_count: int
    model: str
    today: dict[int, int | None]
    without_views: int = 0


def state_of(path: Path, library: Library | None, shown: Sequence[ShownShape]) -> LibraryState:
    """Look at a library.

    Parameters
    ----------
    path : Path
    library : Library or None
        None if there is none at the path.
    shown : sequence of ShownShape

    Returns
    -------
    state : LibraryState
    """
    if library is None:
        return LibraryState(path, 0, "", {shape.shape_id: None for shape in shown})
    today: dict[int, int | None] = {}
    lost = {}
    for shape in shown:
        if _is_same(_record(library, shape.shape_id), shape):
            today[shape.shape_id] = shape.shape_id
        else:
            today[shape.shape_id] = None
            lost[shape.source, shape.name] = shape.shape_id
    if lost:
        for record in library.shapes():
            before = lost.get((record.source, record.name))
            if before is not None:
                today[before] = record.shape_id
    return LibraryState(path, len(library), library.model.name, today, library.count_without_views())


def _record(library: Library, shape_id: int) -> ShapeRecord | None:
    try:
        return library.shape(shape_id)
    except LibraryError:
        return None


def _is_same(record: ShapeRecord | None, shape: ShownShape) -> bool:
    # The file may have been replaced by that of another library, with the same numbers.
    return record is not None and (record.source, record.name) == (shape.source, shape.name)
