# SPDX-License-Identifier: MIT
"""`LibraryComparison`: the part of a library that compares shapes, explains matches and keeps neighbours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from shapegoogle_core.api.arguments import as_tuple, check_count, check_type
from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.parts.contents import LibraryContents
from shapegoogle_core.library.search.evidence.copies import copies_first
from shapegoogle_core.library.search.evidence.explain import by_bags, explain_matches
from shapegoogle_core.library.search.fusion import Fusion
from shapegoogle_core.library.search.query import Query, QueryShapes, as_query_shapes
from shapegoogle_core.library.search.search import Search
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.storage.signatures import check_signature
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh import as_mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibraryComparison"]


class LibraryComparison(LibraryContents):
    """The shapes of a library, and the comparison of shapes with them; the base of `LibrarySearch`.

    Parameters
    ----------
    store : Store
        The open file.
    model : ShapeModel
        The model of the library.
    search : SearchSettings, optional
        Settings of all searches; the default values if left out.
    """

    def __init__(self, store: Store, model: ShapeModel, search: SearchSettings | None = None) -> None:
        super().__init__(store, model)
        self._settings = SearchSettings() if search is None else search
        self._relates_added = True
        self._search = Search(store, model, self._settings)
        # A model without views knows only whether two shapes are the same, which bags alone decide.
        self._graph = None if model.views is None else self._search.neighbour_graph()
        self._fusion = Fusion(
            store,
            model,
            self._settings,
            self._search.nearest_views,
            self._search.reranker,
            self._search.traits,
        )

    def versions(self, shapes: QueryShapes, match: Match, *, explain: int = 10) -> list[Match]:
        """List the family of a match: the shapes that it stands for in a search with ``families=True``.

        Parameters
        ----------
        shapes : MeshLike, ShapeSignature, or sequence of them
            What was searched for.
        match : Match
            From that search.
        explain : int, optional
            Number of best matches that get evidence, see `explain`.

        Returns
        -------
        matches : list of Match
            The match and its versions, as far as they are still in the library; best first.

        Raises
        ------
        MeshError, LibraryError
            As for `query`.
        ValueError
            If `match` is of another type, or `explain` is below 0.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         for size in (1, 2, 3):
        ...             _ = library.add(trimesh.creation.box((size, size, size)), name=f"box {size}")
        ...         _ = library.add(trimesh.creation.torus(2, 0.5), name="ring")
        ...         signature = library.signature(2)
        ...         boxes, ring = library.query(signature, families=True)
        ...         [match.name for match in library.versions(signature, boxes)], boxes.versions
        (['box 2', 'box 1', 'box 3'], 2)
        """
        check_type("match", match, Match, "a Match")
        check_count("explain", explain, 0)
        return self.compare_with(shapes, (match.shape_id, *match.version_ids), explain=explain)

    def compare_with(
        self,
        shapes: QueryShapes,
        shape_ids: Sequence[int],
        *,
        explain: int = 10,
        where: Filter | None = None,
    ) -> list[Match]:
        """Compare a query with certain shapes of the library, whether or not a search would find them.

        Parameters
        ----------
        shapes : MeshLike, ShapeSignature, or sequence of them
            As for `query`.
        shape_ids : sequence of int
            Numbers of shapes.
        explain : int, optional
            Number of best matches that get evidence, see `explain`.
        where : Filter, optional
            As for `explain`.

        Returns
        -------
        matches : list of Match
            As far as the shapes are still in the library; best first, by shape.

        Raises
        ------
        MeshError, LibraryError
            As for `query`.
        ValueError
            If there is no shape to compare with, or `explain` is below 0.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         for size in (1, 2, 3):
        ...             _ = library.add(trimesh.creation.box((size, size, size)), name=f"box {size}")
        ...         match, = library.compare_with(trimesh.creation.box(), [3])
        >>> match.name, match.evidence.kind, match.evidence.factor
        ('box 3', 'scaled', 3.0)
        """
        check_count("explain", explain, 0)
        examples = self._signatures(shapes, "shapes", keep_surface=explain > 0)
        if not examples:
            raise ValueError("there is nothing to compare with: give at least one mesh or signature")
        numbers = np.array(sorted(set(shape_ids)), np.int64)
        found = (
            self._search.among_all(Query(self.model, examples), len(numbers), numbers) if len(numbers) else []
        )
        matches = copies_first(self._store, examples, found)
        return self._shown(examples, matches, explain, where)

    def explain(
        self,
        signatures: QueryShapes,
        matches: Match | Sequence[Match],
        count: int | None = None,
        *,
        where: Filter | None = None,
    ) -> list[Match]:
        """Find the kind of the best matches by comparing surfaces.

        Alignments that the search has found are used again.

        Parameters
        ----------
        signatures : MeshLike, ShapeSignature, or sequence of them
            The examples that were searched for. Signatures without their surface, which
            ``keep_surface=True`` keeps, give coarser figures.
        matches : Match or sequence of Match
            From `query`, best first.
        count : int, optional
            Number of matches to explain; `EvidenceSettings.explained` by default.
        where : Filter, optional
            Conditions of the search. Of several objects that share a mesh, one whose name and size meet them
            is chosen.

        Returns
        -------
        matches : list of Match
            All of them; the first `count` with `Match.evidence`. Shapes that were removed meanwhile, and all
            shapes of a library whose model keeps no samples, have none.

        Raises
        ------
        MeshError
            If one of the examples is not a mesh, or the model cannot describe it.
        LibraryError
            If another model made one of the signatures.
        ValueError
            If `count` is below 0, or one of the matches is of another type.
        """
        count = self._settings.evidence.explained if count is None else count
        check_count("count", count, 0)
        matches = as_tuple("matches", matches, Match, "a Match, or several")
        examples = self._signatures(signatures, "signatures", keep_surface=True)
        explained = explain_matches(
            self._store,
            self.model,
            examples,
            matches[:count],
            self._settings,
            self._search.prepared,
            where,
        )
        return [*explained, *by_bags(self.model, matches[count:])]

    def _signatures(
        self, shapes: QueryShapes, argument: str, *, keep_surface: bool = False
    ) -> list[ShapeSignature]:
        """Describe a mesh or several; signatures are checked and kept."""
        signatures = []
        listed = as_query_shapes(shapes)
        for number, shape in enumerate(listed, start=1):
            name = argument if len(listed) == 1 else f"{argument} {number} of {len(listed)}"
            if isinstance(shape, ShapeSignature):
                check_signature(shape, name, self.model, self._store.name)
                signatures.append(shape)
            else:
                mesh = as_mesh(shape, name)
                signatures.append(self.model.describe(mesh, keep_surface=keep_surface))
        return signatures

    def _shown(
        self, examples: Sequence[ShapeSignature], matches: Sequence[Match], count: int, where: Filter | None
    ) -> list[Match]:
        """Complete matches by their likeness, and the first of them by evidence."""
        if any(match.likeness is None for match in matches):
            matches = self._fusion.with_likeness(examples, matches)
        return self.explain(examples, matches, count, where=where)

    def update_neighbours(self, progress: Wrapper = iter) -> int:
        """Complete the neighbour graph, by which `query` orders the matches behind the first few.

        Adding shapes keeps the graph up to date, so this is for libraries of older programs, and for shapes
        that lost most of their neighbours because these were removed. Indexing does it at its end.

        Parameters
        ----------
        progress : callable, optional
            Wraps the loop over the shapes, as tqdm does.

        Returns
        -------
        count : int
            Number of shapes whose neighbours were found.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         _ = library.add(trimesh.creation.box(), name="box")
        ...         library.update_neighbours()
        0
        """
        return 0 if self._graph is None else self._graph.catch_up(progress)

    @contextmanager
    def neighbours_later(self) -> Iterator[None]:
        """Add shapes without finding their neighbours, which `update_neighbours` does later for all.

        Returns
        -------
        context : context manager
            Inside it, added shapes get no neighbours.
        """
        self._relates_added = False
        try:
            yield
        finally:
            self._relates_added = True

    def _added(self, shape_ids: Sequence[int]) -> None:
        if self._graph is not None and self._relates_added:
            self._graph.add(shape_ids)
