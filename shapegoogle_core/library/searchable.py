# SPDX-License-Identifier: MIT
"""`SearchableLibrary`: what programs use of a library, wherever it lies."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Protocol, Self

if TYPE_CHECKING:
    from shapegoogle_core.library.decisions.decision import Decision, DecisionKind
    from shapegoogle_core.library.duplicates.groups import DuplicateGroup
    from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
    from shapegoogle_core.library.filter import Filter
    from shapegoogle_core.library.match import Match
    from shapegoogle_core.library.placement import Placement
    from shapegoogle_core.library.search.query import QueryShape, QueryShapes
    from shapegoogle_core.library.search.settings import Rank
    from shapegoogle_core.library.storage.records import Root, ShapeRecord
    from shapegoogle_core.library.suggestions import Suggestion
    from shapegoogle_core.model import ShapeModel
    from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["SearchableLibrary"]


class SearchableLibrary(Protocol):
    """A library that can be searched and decided in: a `Library`, or a `ServiceLibrary`.

    `Library` describes all methods. Adding, removing and moving files needs a `Library`.
    """

    @property
    def name(self) -> str:
        """Path or address, as messages name it."""

    @property
    def model(self) -> ShapeModel:
        """The model that describes its shapes."""

    def __len__(self) -> int: ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...

    def close(self) -> None:
        """Close it."""

    # -- search ---------------------------------------------------------------------------------------------

    def query(
        self,
        shapes: QueryShapes,
        *,
        top: int = 10,
        explain: int = 10,
        exact: bool = False,
        unlike: QueryShapes = (),
        where: Filter | None = None,
        families: bool = False,
        rank: Rank = "both",
    ) -> list[Match]:
        """See `Library.query`."""

    def explain(
        self,
        signatures: QueryShapes,
        matches: Match | Sequence[Match],
        count: int | None = None,
        *,
        where: Filter | None = None,
    ) -> list[Match]:
        """See `Library.explain`."""

    def versions(self, shapes: QueryShapes, match: Match, *, explain: int = 10) -> list[Match]:
        """See `Library.versions`."""

    def compare_with(
        self,
        shapes: QueryShapes,
        shape_ids: Sequence[int],
        *,
        explain: int = 10,
        where: Filter | None = None,
    ) -> list[Match]:
        """See `Library.compare_with`."""

    def suggest(
        self, shape: QueryShape | int, *, relatives: int = 8, where: Filter | None = None
    ) -> list[Suggestion]:
        """See `Library.suggest`."""

    def duplicates(
        self, min_similarity: float = ..., progress: Wrapper | None = None, *, explained: int = ...
    ) -> list[DuplicateGroup]:
        """See `Library.duplicates`."""

    # -- decisions ------------------------------------------------------------------------------------------

    def decide(
        self,
        kind: DecisionKind,
        shape: int | ShapeSignature,
        other: int | None = None,
        *,
        tag: str = "",
        author: str = "",
        name: str = "",
        source: str = "",
    ) -> Decision:
        """See `Library.decide`."""

    def decisions(self) -> list[Decision]:
        """See `Library.decisions`."""

    def undo(self, number: int) -> Decision:
        """See `Library.undo`."""

    # -- contents -------------------------------------------------------------------------------------------

    def info(self) -> dict[str, object]:
        """See `Library.info`."""

    def count_without_views(self) -> int:
        """See `Library.count_without_views`."""

    def reindexing_advice(self) -> str:
        """See `Library.reindexing_advice`."""

    def roots(self) -> list[Root]:
        """See `Library.roots`."""

    def map_root(self, name: str, folder: str | os.PathLike[str]) -> None:
        """See `Library.map_root`."""

    def find(self, where: Filter | None = None, *, after: int = 0, limit: int = 100) -> list[ShapeRecord]:
        """See `Library.find`."""

    def shapes(self) -> Iterator[ShapeRecord]:
        """See `Library.shapes`."""

    def shape(self, shape_id: int) -> ShapeRecord:
        """See `Library.shape`."""

    def records(self, shape_ids: Sequence[int]) -> list[ShapeRecord]:
        """See `Library.records`."""

    def has_shape(self, shape_id: int) -> bool:
        """See `Library.has_shape`."""

    def signature(self, shape_id: int) -> ShapeSignature:
        """See `Library.signature`."""

    def placements(self, shape_id: int) -> tuple[Placement, ...]:
        """See `Library.placements`."""

    def thumbnail(self, shape_id: int) -> bytes | None:
        """See `Library.thumbnail`."""

    def thumbnails(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """See `Library.thumbnails`."""

    def preview(self, shape_id: int) -> bytes | None:
        """See `Library.preview`."""
