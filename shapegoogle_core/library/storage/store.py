# SPDX-License-Identifier: MIT
"""`Store`: the operations of a library's storage, whatever database is behind it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.decisions.decision import Decision, ShapeKey
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.storage.records import (
    CopyBatch,
    NewShape,
    Rearrangement,
    Root,
    ShapeRecord,
    SourceKey,
    SourceRecord,
    StoreSummary,
)
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["CodeKind", "CodePage", "Neighbours", "Store", "all_codes", "damaged"]

CodeKind = Literal["codes", "local_words", "view_codes"]
"""The binary codes of bags, the local words of each shape as bits, or the binary codes of views."""

Neighbours = tuple[NDArray[np.int64], NDArray[np.float32]]
"""Ids of shapes (k,) and their distances (k,), nearest first."""

CodePage = tuple[NDArray[np.int64], NDArray[np.uint8]]
"""Ids of shapes (n,), in ascending order, and their codes (n, code_bytes)."""


class Store(Protocol):
    """An open library.

    Ids of shapes ascend in the order in which shapes are added, and no id is given twice. Every change is one
    transaction: when the method returns all of it is stored, and after an error nothing. Every method raises
    `LibraryError` if the database reports an error or the content is damaged. A store belongs to the thread
    that opened it.
    """

    @property
    def name(self) -> str:
        """Path or address, as error messages name the library."""

    @property
    def read_only(self) -> bool:
        """Whether changes are refused."""

    def close(self) -> None:
        """Close the library. Closing twice does no harm."""

    def snapshot(self) -> AbstractContextManager[None]:
        """Let all reads inside the context see one state. Writers may have to wait, so be quick."""

    def model(self) -> tuple[str, bytes]:
        """Return identifier and file content of the model that described the shapes."""

    def extend_model(self, identifier: str, content: bytes) -> None:
        """Store the content of a model that has more parts than the stored one, with the next change.

        Parameters
        ----------
        identifier : str
            That of the stored model.
        content : bytes
            Result of `ShapeModel.to_bytes`.
        """

    def summary(self) -> StoreSummary:
        """Return numbers about the whole library."""

    # -- changes --------------------------------------------------------------------------------------------

    def add(self, source: SourceKey | None, shape: NewShape[ShapeSignature]) -> int:
        """Add one shape; it replaces the one with the same source, object name and name.

        Decisions on its tags are kept.

        Parameters
        ----------
        source : SourceKey or None
            None: the shape has no source and replaces nothing.
        shape : NewShape

        Returns
        -------
        shape_id : int
        """

    def replace_source(
        self,
        source: SourceRecord,
        shapes: Iterable[NewShape[ShapeSignature]],
        *,
        also: SourceKey | None = None,
        claim: bool = False,
    ) -> list[int]:
        """Store a source and its shapes in place of everything stored for this source before.

        Decisions on the tags of its shapes are kept.

        Parameters
        ----------
        source : SourceRecord
            Its root must be known; its `path` below a root, and its `shape_count`, are not used.
        shapes : iterable of NewShape
        also : SourceKey, optional
            Another source that is replaced too: the same file under another name.
        claim : bool, optional
            Leave everything as it is if the source is stored with the same content already, because another
            program was faster.

        Returns
        -------
        shape_ids : list of int
            In the order of `shapes`.
        """

    def update_source(self, source: SourceKey, size: int, mtime_ns: int) -> bool:
        """Store the new size and time of change of a source; return False if the source is unknown."""

    def remove_sources(self, sources: Iterable[SourceKey]) -> int:
        """Remove sources with all their shapes; return how many of them were known."""

    def rearrange(self, changes: Rearrangement) -> None:
        """Change roots, and the places of sources below them.

        Parameters
        ----------
        changes : Rearrangement
            No two sources may have the same key afterwards.
        """

    def remove_shapes(self, shape_ids: Iterable[int]) -> int:
        """Remove single shapes; return how many of them were there."""

    def last_id(self) -> int:
        """Return the greatest number that a shape has ever had; 0 if there was none."""

    def copy_mark(self) -> str | None:
        """Return the name of the library that this is an unfinished copy of; None for any other library."""

    def put_copy(self, batch: CopyBatch) -> None:
        """Store a part of another library, and whether it is the last.

        Parameters
        ----------
        batch : CopyBatch
        """

    # -- records --------------------------------------------------------------------------------------------

    def count(self) -> int:
        """Return the number of shapes."""

    def roots(self, *, counted: bool = False) -> list[Root]:
        """Return all roots in the order of their names, with the numbers of their sources if requested."""

    def map_root(self, root: Root, path: str) -> None:
        """Let a root lie elsewhere on this computer, until the library is closed; nothing is stored.

        Parameters
        ----------
        root : Root
        path : str
            Absolute.
        """

    def known_sources(self, keys: Sequence[SourceKey]) -> list[SourceKey]:
        """Return those of some keys that are sources, in their order."""

    def sources(self) -> list[SourceRecord]:
        """Return all sources in the order of their full paths."""

    def source_of(self, shape_id: int) -> SourceRecord | None:
        """Return the source of a shape, None if it has none, or there is no such shape."""

    def shapes(self, shape_ids: Sequence[int]) -> list[ShapeRecord]:
        """Return the records of these shapes in the order of their ids, without unknown ones."""

    def shapes_after(self, last_id: int, limit: int) -> list[ShapeRecord]:
        """Return the next records in the order of ids; start with `last_id` 0."""

    def filtered_ids(self, where: Filter) -> NDArray[np.int64]:
        """Find the shapes that meet the conditions of a filter that are known before a search.

        Parameters
        ----------
        where : Filter
            Name, folder, sources, tag, faces and size; its other conditions are not used.

        Returns
        -------
        shape_ids : (n,) array of int64
            In ascending order.
        """

    def placements(self, shape_ids: Sequence[int]) -> dict[int, tuple[Placement, ...]]:
        """Return the placements of those of some shapes that have any, by id."""

    # -- signatures -----------------------------------------------------------------------------------------

    def code_pages(self, kind: CodeKind, last_id: int, code_bytes: int) -> Iterator[CodePage]:
        """Read the codes of all shapes after an id, in pages; use them up within one `snapshot`.

        Parameters
        ----------
        kind : {"codes", "local_words", "view_codes"}
        last_id : int
            0 for all shapes; the last id seen, for those that were added since.
        code_bytes : int
            Length of each code.

        Yields
        ------
        shape_ids : (n,) array of int64
        codes : (n, code_bytes) array of uint8
        """

    def codes(self, kind: CodeKind, shape_ids: Sequence[int], code_bytes: int) -> CodePage:
        """Return ids (sorted, without unknown ones) and codes (n, code_bytes) of these shapes."""

    def nearest_codes(
        self, code: NDArray[np.uint8], count: int, among: NDArray[np.int64] | None = None
    ) -> NDArray[np.int64] | None:
        """Find the shapes whose codes of bags are nearest to one, if the database does this itself.

        Parameters
        ----------
        code : (code_bytes,) array of uint8
        count : int
            Number of shapes to find; fewer come back when there are fewer.
        among : (m,) array of int64, optional
            Ids of the shapes to choose from; all shapes by default.

        Returns
        -------
        shape_ids : (min(count, n),) array of int64, or None
            Nearest first; among equals the lowest id first. None: all codes are to be compared in memory.
        """

    def bags(self, shape_ids: Sequence[int], bag_size: int) -> tuple[list[int], NDArray[np.float32]]:
        """Return ids (sorted, without unknown ones) and bags (n, bag_size) of these shapes."""

    def bags_after(self, last_id: int, limit: int, bag_size: int) -> tuple[list[int], NDArray[np.float32]]:
        """Return ids and bags (n, bag_size) of the next shapes by id; start with `last_id` 0."""

    def samples(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """Return the surface samples of these shapes by id, in the format of `SurfaceSample.to_bytes`."""

    def measures(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """Return the measures of these shapes by id, in the format of `MeshMeasures.to_bytes`."""

    def thumbnail(self, shape_id: int) -> bytes | None:
        """Return the picture of a shape as PNG, or None if it has none."""

    def preview(self, shape_id: int) -> bytes | None:
        """Return the small mesh of a shape that can be shown, or None if it has none."""

    # -- decisions ------------------------------------------------------------------------------------------

    def shape_keys(self, shape_ids: Sequence[int]) -> dict[int, ShapeKey]:
        """Return the keys of those of some shapes that are there, by id; their fingerprints are left out."""

    def shapes_of(self, keys: Sequence[ShapeKey]) -> list[int | None]:
        """Find the shapes that keys name now.

        Parameters
        ----------
        keys : sequence of ShapeKey

        Returns
        -------
        shape_ids : list of (int or None)
            For each key the shape with this source, object name and name. Otherwise the only shape of the
            same object name in a file of the same content, and of the same name if it is an object. None if
            there is no such shape. Without a source: the only shape without one that has these names.
        """

    def decisions(self) -> list[Decision]:
        """Return all decisions, oldest first."""

    def add_decision(self, decision: Decision) -> int:
        """Store a decision, and the tag that it gives to a shape or takes from it.

        Parameters
        ----------
        decision : Decision
            Its number is not used.

        Returns
        -------
        number : int
            Never given twice.
        """

    def remove_decision(self, number: int) -> Decision | None:
        """Remove a decision and its effect on tags; return it, or None if it is unknown."""

    # -- shapes of the same kind ----------------------------------------------------------------------------

    def views(self, shape_ids: Sequence[int], size: int) -> tuple[list[int], NDArray[np.uint8]]:
        """Return ids (sorted) and packed views (n, size) of those of some shapes that have views."""

    def count_without_views(self) -> int:
        """Return the number of shapes without views, such as those that an earlier version has described."""

    def sources_without_views(self) -> list[SourceKey]:
        """Return the sources that shapes without views come from."""

    def neighbours(self, shape_ids: Sequence[int]) -> dict[int, Neighbours]:
        """Return the nearest shapes of those of some shapes that have them, by id.

        Some of them may have been removed since they were stored.
        """

    def put_neighbours(self, neighbours: Mapping[int, Neighbours]) -> None:
        """Store the nearest shapes of some shapes by id; shapes that are gone are left out."""

    def without_neighbours(self, last_id: int, limit: int) -> list[int]:
        """Return the next ids of shapes without neighbours, in order; start with `last_id` 0."""


def all_codes(store: Store, kind: CodeKind, code_bytes: int) -> CodePage:
    """Read the codes of all shapes at once.

    Parameters
    ----------
    store : Store
    kind : {"codes", "local_words", "view_codes"}
    code_bytes : int
        Length of each code.

    Returns
    -------
    shape_ids : (n,) array of int64
        In ascending order.
    codes : (n, code_bytes) array of uint8
    """
    shape_ids = [np.empty(0, np.int64)]
    codes = [np.empty((0, code_bytes), np.uint8)]
    with store.snapshot():
        for page_ids, page in store.code_pages(kind, 0, code_bytes):
            shape_ids.append(page_ids)
            codes.append(page)
    return np.concatenate(shape_ids), np.concatenate(codes)


def damaged(library: str, detail: str) -> LibraryError:
    """Make the error for a library whose content contradicts itself.

    Parameters
    ----------
    library : str
        Name of the library, see `Store.name`.
    detail : str
        The contradiction.

    Returns
    -------
    error : LibraryError
    """
    return LibraryError(
        "'{library}' is damaged or was cut short ({detail}); restore it from a backup, or delete it and "
        "index your folders again",
        library=library,
        detail=detail,
    )
