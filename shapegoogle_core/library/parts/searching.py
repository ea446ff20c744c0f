# SPDX-License-Identifier: MIT
"""`LibrarySearch`: the part of a library that finds shapes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from shapegoogle_core.api.arguments import check_count, check_type
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.neighbours.reorder import WalkReranker
from shapegoogle_core.library.parts.comparing import LibraryComparison
from shapegoogle_core.library.search.evidence.copies import copies_first
from shapegoogle_core.library.search.evidence.explain import by_bags
from shapegoogle_core.library.search.families import Families, collect_families, families_accepted
from shapegoogle_core.library.search.query import Query, QueryShape, QueryShapes
from shapegoogle_core.library.search.settings import RANKS, Rank, SearchSettings
from shapegoogle_core.library.search.stages import RERANKERS, MatchReranker, chosen, reorder
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.library.suggestions import Suggestion, suggestions_from
from shapegoogle_core.library.suggestions.suggest import RELATIVES
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibrarySearch"]

# Matches that are explained at once to find those of a kind.
KIND_PORTION = 10


class LibrarySearch(LibraryComparison):
    """The search in a library; see `Library`.

    Parameters
    ----------
    store, model, search
        See `LibraryComparison`.
    """

    def __init__(self, store: Store, model: ShapeModel, search: SearchSettings | None = None) -> None:
        super().__init__(store, model, search)
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
