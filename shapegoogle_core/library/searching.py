# SPDX-License-Identifier: MIT
"""`LibrarySearch`: the part of a library that finds shapes and explains matches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np

from shapegoogle_core.api.arguments import as_tuple, check_count, check_type
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.contents import LibraryContents
from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.neighbours.reorder import WalkReranker
from shapegoogle_core.library.search.evidence.copies import copies_first
from shapegoogle_core.library.search.evidence.explain import by_bags, explain_matches
from shapegoogle_core.library.search.families import Families, collect_families, families_accepted
from shapegoogle_core.library.search.fusion import Fusion
from shapegoogle_core.library.search.query import Query, QueryShape, QueryShapes, as_query_shapes
from shapegoogle_core.library.search.search import Search
from shapegoogle_core.library.search.settings import RANKS, Rank, SearchSettings
from shapegoogle_core.library.search.stages import RERANKERS, MatchReranker, chosen, reorder
from shapegoogle_core.library.storage.signatures import check_signature
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.library.suggestions import Suggestion, suggestions_from
from shapegoogle_core.library.suggestions.suggest import RELATIVES
from shapegoogle_core.mesh import as_mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibrarySearch"]

# Matches that are explained at once to find those of a kind.
KIND_PORTION = 10


class LibrarySearch(LibraryContents):
    """The shapes of a library and the search in them; see `Library`.

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
        self._reranker: MatchReranker | None = None
        if self._settings.rerank.reranker is not None:
            self._reranker = chosen(RERANKERS, self._settings.rerank.reranker)(store, model, self._settings)

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
        """Find the shapes of the library that are most similar to a shape, or to several examples of one.

        The binary codes of all shapes are compared first (algorithm 2 of the paper), the nearest then by
        their full bags, and the best of these are aligned with the query, if the model takes samples of
        surfaces. `SearchSettings` holds the numbers of candidates; `shapegoogle_core.library.search.query`
        explains the distance to several examples.

        Parameters
        ----------
        shapes : MeshLike, ShapeSignature, or sequence of them
            In any pose, at any size. Several are examples of one thing: shapes near to all of them come
            first. A signature is one of this library's model; described with ``keep_surface=True`` its
            evidence is exact.
        top : int, optional
            Number of matches; fewer are returned if the library has fewer shapes, or fewer pass the filter.
        explain : int, optional
            Number of best matches that get evidence, see `explain`.
        exact : bool, optional
            Compare the full bags of all shapes: no shape can be missed, but the time grows with the library.
        unlike : MeshLike, ShapeSignature, or sequence of them, optional
            Negative examples: shapes near to one of them are ranked lower, copies last.
        where : Filter, optional
            Conditions on the matches. To find a kind of evidence or a least similarity, the best
            `EvidenceSettings.max_filtered` matches that meet the other conditions are explained, until `top`
            have it.
        families : bool, optional
            Find `top` different shapes instead of `top` shapes: of all copies and versions of a shape only
            the best is returned, with the number of the others, see `Match.versions`.
        rank : {"both", "shape", "kind"}, optional
            What comes first: the same shape and then others of its kind; only by how likely they are the same
            shape; or only by how likely they are of the same kind. A model that has not learnt about kinds
            always orders by shape.

        Returns
        -------
        matches : list of Match
            Best first; of those at the least distance identical ones, then other copies, then by name.
            Without those that were decided not to match one of the shapes, see `Library.decide`.

        Raises
        ------
        MeshError
            If one of the shapes is not a mesh, or the model cannot describe it.
        LibraryError
            If another model made one of the signatures, or if a kind of evidence is requested and the model
            takes no samples of surfaces; or if a stage of a plug-in fails.
        ValueError
            If there is no shape, if `top` is below 1 or `explain` below 0, if there is no such `rank`, or if
            an argument is of a wrong type.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         _ = library.add(trimesh.creation.box(), name="box")
        ...         _ = library.add(trimesh.creation.icosphere(2), name="ball")
        ...         [match.name for match in library.query(trimesh.creation.box(), top=1)]
        ['box']
        """
        check_count("top", top, 1)
        check_count("explain", explain, 0)
        check_type("where", where, (Filter, type(None)), "a shapegoogle_core.Filter")
        if rank not in RANKS:
            raise ValueError(f"there is no order {rank!r}; choose one of {', '.join(RANKS)}")
        kind = None if where is None else where.kind
        if kind is not None and self.model.settings.sample is None:
            raise LibraryError(
                f"'{self._store.name}' keeps no samples of surfaces to find the kind {kind!r} with, because "
                f"its model {self.model.name!r} takes none; leave the kind out"
            )
        examples = self._signatures(shapes, "query", keep_surface=explain > 0 or kind is not None)
        if not examples:
            raise ValueError("there is nothing to search for: give at least one mesh or signature")
        negative = self._signatures(unlike, "unlike")
        hidden = self._hidden(examples)
        query = Query(self.model, examples, negative, self._settings.rerank.unlike_weight)
        among = self._store.filtered_ids(where) if where is not None and where.selects_shapes else None
        search = self._search.among_all if exact else self._search.among_nearest_codes
        least = None if where is None else where.min_similarity
        evidence = self._settings.evidence
        kept = top if kind is None and least is None else max(top, evidence.max_filtered)
        graph = None if query.has_unlike or rank == "shape" else self._graph
        walk = None if graph is None else WalkReranker(graph)
        rerankers = [reranker for reranker in (walk, self._reranker) if reranker is not None]
        searched = len(hidden) + (max(kept, self._settings.walk.walked) if rerankers else kept)

        def ordered(matches: Sequence[Match], count: int) -> list[Match]:
            fused = self._fusion.order(
                query, examples, negative, matches, count, among, rank=rank, exact=exact
            )
            listed = copies_first(self._store, examples, fused)
            for reranker in rerankers:
                listed = reorder(reranker, query, listed)
            return [match for match in listed if match.shape_id not in hidden]

        def more(count: int) -> list[Match]:
            return ordered(self._search.among_more(query, count, found, among, exact=exact), count)

        found = search(query, searched, among)
        matches = ordered(found, searched)
        if families:
            members = collect_families(
                Families(self._store, self.model, self._settings.families),
                kept,
                matches,
                lambda count: more(count + len(hidden)),
                len(self) if among is None else len(among),
            )
            if where is None or (kind is None and least is None):
                return self._shown(examples, [family.best for family in members], explain, where)
            explained = 0 if kind is None and explain == 0 else kept
            return families_accepted(
                members,
                partial(_accepts, where),
                lambda some: self._shown(examples, some, min(explained, len(some)), where),
                top,
                kept,
            )
        if where is not None and (kind is not None or least is not None):
            return self._accepted(examples, matches[:kept], top, explain, where)
        return self._shown(examples, matches[:top], explain, where)

    def _hidden(self, examples: Sequence[ShapeSignature]) -> frozenset[int]:
        """Return the numbers of shapes that are left out of the answer to some examples."""
        del examples
        return frozenset()

    def suggest(
        self, shape: QueryShape | int, *, relatives: int = RELATIVES, where: Filter | None = None
    ) -> list[Suggestion]:
        """Suggest tags, catalogs, folders and name words for a shape: those of its nearest relatives.

        Parameters
        ----------
        shape : MeshLike, ShapeSignature or int
            A number is that of a shape of this library, which does not count as a relative of its own.
        relatives : int, optional
            Number of nearest relatives that vote.
        where : Filter, optional
            Conditions on the relatives.

        Returns
        -------
        suggestions : list of Suggestion
            The most confident first; only what is in the library already.

        Raises
        ------
        MeshError, LibraryError
            As for `query`; also if there is no shape with this number.
        ValueError
            If `relatives` is below 1, or an argument is of a wrong type.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         _ = library.add(trimesh.creation.box((1, 2, 3)), name="WoodenCrate", tags=["storage"])
        ...         first, *_ = library.suggest(trimesh.creation.box((1, 2, 3.1)))
        >>> first.kind, first.text, first.relatives
        ('tag', 'storage', ('WoodenCrate',))
        """
        check_count("relatives", relatives, 1)
        own = shape if isinstance(shape, int) else None
        asked = self.signature(shape) if isinstance(shape, int) else shape
        matches = self.query(asked, top=relatives + (own is not None), explain=0, where=where)
        near = [match for match in matches if match.shape_id != own][:relatives]
        records = {record.shape_id: record for record in self._store.shapes([m.shape_id for m in near])}
        # Without those that another program removed meanwhile.
        there = [match for match in near if match.shape_id in records]
        return suggestions_from(
            [records[match.shape_id] for match in there], [match.distance for match in there]
        )

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
        explained = explain_matches(self._store, self.model, examples, matches[:count], self._settings, where)
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

    def _accepted(
        self,
        examples: Sequence[ShapeSignature],
        matches: Sequence[Match],
        top: int,
        explain: int,
        where: Filter,
    ) -> list[Match]:
        """Choose matches by the figures that are shown: explain portions until enough are accepted."""
        if explain == 0 and where.kind is None:
            shown = self._shown(examples, matches, 0, where)
            return [match for match in shown if _accepts(where, match)][:top]
        found: list[Match] = []
        matches = self._promising(matches, where)
        for start in range(0, len(matches), KIND_PORTION):
            portion = matches[start : start + KIND_PORTION]
            explained = self._shown(examples, portion, len(portion), where)
            found += [match for match in explained if _accepts(where, match)]
            if len(found) >= top:
                break
        return found[:top]

    def _promising(self, matches: Sequence[Match], where: Filter) -> list[Match]:
        """Leave out matches that are hardly similar enough: surfaces make a few of the others so."""
        least = where.min_similarity
        if least is None:
            return list(matches)
        by_bags_alone = by_bags(self.model, matches)
        similarity = [
            max(match.similarity, other.similarity)
            for match, other in zip(matches, by_bags_alone, strict=True)
        ]
        others = sorted(
            (number for number, value in enumerate(similarity) if value < least),
            key=lambda number: -similarity[number],
        )
        left_out = set(others[self._settings.evidence.explained :])
        return [match for number, match in enumerate(matches) if number not in left_out]


def _accepts(where: Filter, match: Match) -> bool:
    """Whether a match with its final figures meets the conditions that are known after a search."""
    if where.min_similarity is not None and match.similarity < where.min_similarity:
        return False
    return where.kind is None or (match.evidence is not None and match.evidence.kind == where.kind)
