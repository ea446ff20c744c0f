# SPDX-License-Identifier: MIT
"""What a user interface shows of a library: its size and model, and which of the shapes it still has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shapegoogle_core.client import LibraryAddress, ServiceLibrary
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.searchable import SearchableLibrary
from shapegoogle_core.library.storage.records import Root, ShapeRecord

__all__ = ["LibraryState", "ShownShape", "state_of"]

# Shapes of one file among which those that are shown are searched.
_MOST_OF_A_FILE = 100_000


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
    library : LibraryAddress
        As it was asked for.
    shape_count : int
    model : str
        Name of its model; empty if there is no library.
    today : dict of int to int or None
        For the number of each shape asked for its number now: another one if its file was indexed again, None
        if it is not in the library any more.
    roots : tuple of Root
        Of the library; those of a service that are not known here have no path.
    model_file : str
        File with the model of a service; empty for a library in a file or a database.
    without_views : int
        Number of shapes that an earlier version has described without views: the search for more of the same
        kind does not find them.
    """

    library: LibraryAddress
    shape_count: int
    model: str
    today: dict[int, int | None]
    without_views: int = 0
    roots: tuple[Root, ...] = ()
    model_file: str = ""


def state_of(
    address: LibraryAddress, library: SearchableLibrary | None, shown: Sequence[ShownShape]
) -> LibraryState:
    """Look at a library.

    Parameters
    ----------
    address : LibraryAddress
    library : SearchableLibrary or None
        None if there is none at the address.
    shown : sequence of ShownShape

    Returns
    -------
    state : LibraryState
    """
    if library is None:
        return LibraryState(address, 0, "", {shape.shape_id: None for shape in shown})
    records = {record.shape_id: record for record in library.records([shape.shape_id for shape in shown])}
    today: dict[int, int | None] = {}
    lost = {}
    for shape in shown:
        if _is_same(records.get(shape.shape_id), shape):
            today[shape.shape_id] = shape.shape_id
        else:
            today[shape.shape_id] = None
            lost[shape.source, shape.name] = shape.shape_id
    for source in sorted({source for source, _ in lost}):
        for record in library.find(Filter(sources=(source,)), limit=_MOST_OF_A_FILE):
            before = lost.get((record.source, record.name))
            if before is not None:
                today[before] = record.shape_id
    return LibraryState(
        address,
        len(library),
        library.model.name,
        today,
        library.count_without_views(),
        tuple(library.roots()),
        str(library.model_file) if isinstance(library, ServiceLibrary) else "",
    )


def _is_same(record: ShapeRecord | None, shape: ShownShape) -> bool:
    # The file may have been replaced by that of another library, with the same numbers.
    return record is not None and (record.source, record.name) == (shape.source, shape.name)
