# SPDX-License-Identifier: MIT
"""The search: Hamming distance over all codes, the full bags of the nearest (algorithm 2), then geometry.

Where bags are not sure, shapes that share parts with the query are looked at as well: those that have most of
its local words, see `LocalWords`, and of these the ones with the most support in space, see `supports`.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.codes.code_index import CodeIndex, best_table
from shapegoogle_core.library.search.codes.hamming import asymmetric_distances
from shapegoogle_core.library.search.codes.shape_index import ShapeIndex
from shapegoogle_core.library.search.codes.word_index import WordIndex
from shapegoogle_core.library.search.query import FARTHEST, Question
from shapegoogle_core.library.search.verify import CERTAIN, SCREENED, Examples, Sharing, verify
from shapegoogle_core.library.storage.samples import stored_supports
from shapegoogle_core.library.storage.store import CodeKind, Store
from shapegoogle_core.model import ShapeModel

__all__ = ["CANDIDATES", "CANDIDATES_PER_MATCH", "Search"]

# How many of the shapes with the nearest codes are compared by their full bags.
CANDIDATES = 300
# Where more matches are asked for, so many candidates for each of them: codes order shapes only roughly.
CANDIDATES_PER_MATCH = 4
# So many times as many codes are read, and then chosen from by more than their distance.
ROUGH_PER_CANDIDATE = 4
# How many of the shapes that have most of the query's local words are compared with it in space too, for each
# size that the query may have beside a match; and over how many of these pairs it is laid: those of most
# support · (1 + r/r₀)^-p, with r their rank by words. Of parts asked for among 1,147 creatures, 33 of each
# kind, all wholes of halves are among them, four of five wholes of thirds, and nine of ten of the shapes that
# share a half with another one; of the latter seven of ten would be among as many pairs by words alone.
LOCAL_CANDIDATES, SUPPORTED = 800, 400
RANK_UNIT, RANK_POWER = 50, 0.25
# Geometry is not asked where several examples find their best match, other than a copy, so similar by bags.
# They say in which ways a shape varies, geometry knows each in one pose: on pairs of creatures damaged by
# noise, holes and moderate cuts it only did harm there; of large cuts, which need it, bags are never so sure.
CERTAIN_OF_SEVERAL = 0.5
# Bags in memory at once, in entries: 32 MB as float32.
BAG_ENTRIES_AT_ONCE = 8_000_000
# Codes of removed shapes that are kept in memory and skipped, before all are read again.
MAX_GONE = 1_000


class Search:
    """Finds shapes in a store; keeps all codes in memory from the first search on, and reads only new ones.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        The one that described the shapes.
    """

    def __init__(self, store: Store, model: ShapeModel) -> None:
        self._store = store
        self._model = model
        code_bytes = model.code_bits // 8
        self._codes = _Codes(
            store, "codes", code_bytes, lambda: CodeIndex(code_bytes, best_table(store.last_id()))
        )
        self._local_words: _Codes[WordIndex] | None = None
        if model.settings.local is not None:
            word_bytes = model.settings.local.words // 8
            self._local_words = _Codes(store, "local_words", word_bytes, lambda: WordIndex(word_bytes))
        self._bags_at_once = max(1, BAG_ENTRIES_AT_ONCE // model.bag_size)

    def among_nearest_codes(self, question: Question, top: int) -> list[Match]:
        """Compare the full bags of the shapes with the nearest codes, and lay the best over the query.

        Parameters
        ----------
        question : Question
            Candidates are the shapes whose codes are nearest to one of its examples.
        top : int

        Returns
        -------
        matches : list of Match
            The min(top, shapes) best, best first.
        """
        wanted = max(CANDIDATES, CANDIDATES_PER_MATCH * top)
        compared = _compared(question, top)
        # In one snapshot: a candidate must not vanish between its code and its bags.
        with self._store.snapshot():
            best = self._best_of(question, self._codes, partial(self._nearest, question, wanted), compared)
        return self._verified(question, best)[:top]

    def among_all(self, question: Question, top: int) -> list[Match]:
        """Compare the full bags of all shapes; else as `among_nearest_codes`."""
        while True:
            best = self._scan(question, _compared(question, top))
            if len(self._store.shapes([match.shape_id for match in best])) == len(best):
                return self._verified(question, best)[:top]
            # A writer removed one of the best meanwhile: what it had displaced must come in, so look again.

    def _nearest(self, question: Question, count: int, codes: CodeIndex) -> list[int]:
        """Ids of the shapes with the codes nearest to one of the examples.

        Bits say on which side of a threshold a projection lies. Of the query it is also known how far: among
        those with the nearest codes, the bits count by that (see `asymmetric_distances`).
        """
        nearest: list[int] = []
        for code, projection in zip(question.codes, question.projections, strict=True):
            rough = codes.nearest(code, ROUGH_PER_CANDIDATE * count).tolist()
            if len(rough) <= count:  # all are wanted: their bags decide, and tell which are gone
                nearest += rough
                continue
            shape_ids, known = self._store.codes("codes", rough, self._model.code_bits // 8)
            order = np.argsort(asymmetric_distances(known, projection), kind="stable")[:count]
            nearest += shape_ids[order].tolist()
            nearest += set(rough).difference(shape_ids.tolist())  # they have no bags either: found gone there
        # Each once, however many examples it is near to.
        return list(dict.fromkeys(nearest))

    def _best_of(
        self, question: Question, codes: _Codes[_I], nearest: Callable[[_I], list[int]], top: int
    ) -> list[Match]:
        """Compare the bags of the shapes that `nearest` finds in an index of codes."""
        for _ in range(2):
            index = codes.current()
            best, gone = self._compare(question, nearest(index), top)
            if not gone:
                return best
            # Removed since their codes were read, by whomever; others come in for them.
            index.discard(gone)
        # More were removed than just these, so read all again.
        codes.forget()
        return self._compare(question, nearest(codes.current()), top)[0]

    def _compare(self, question: Question, candidates: list[int], top: int) -> tuple[list[Match], set[int]]:
        """Compare the full bags of some shapes with the question. Second: the ids of those that are gone."""
        best: list[Match] = []
        gone: set[int] = set()
        for start in range(0, len(candidates), self._bags_at_once):
            portion = candidates[start : start + self._bags_at_once]
            shape_ids, bags = self._store.bags(portion, self._model.bag_size)
            gone |= set(portion).difference(shape_ids)
            best = self._merge(best, question, shape_ids, bags, top)
        return best, gone

    def _verified(self, question: Question, matches: list[Match]) -> list[Match]:
        if question.samples:
            # That a copy of one of several examples is certain says nothing of the others.
            copies = [match for match in matches if question.several and match.distance == 0]
            rest = matches[len(copies) :]
            if rest and rest[0].similarity < (CERTAIN_OF_SEVERAL if question.several else CERTAIN):
                known = {match.shape_id for match in matches}
                examples = Examples(question.samples, partial(self._views, question))
                sharing = partial(self._sharing_parts, question, examples, known)
                rest = verify(self._store, self._model, examples, rest, sharing)
            matches = [*copies, *rest]
        if not question.has_unlike:
            return matches
        # In order by now: the very last ones are farther than a distance can be.
        return [replace(match, distance=min(match.distance, FARTHEST)) for match in matches]

    def _sharing_parts(self, question: Question, examples: Examples, known: set[int]) -> Sharing:
        """Shapes that have most of the query's local words; of those, the ones most supported in space."""
        words = self._model.local_words
        if words is None or self._local_words is None:
            return Sharing({}, [])
        weights = [words.query_weights(query.prepared.sample) for query in examples.queries]
        scales: dict[int, set[int]] = {}

        def supported(index: WordIndex) -> list[int]:
            scales.clear()
            for shape_id, scale in self._most_supported(index, examples, weights):
                scales.setdefault(shape_id, set()).add(scale)
            return [shape_id for shape_id in scales if shape_id not in known]

        with self._store.snapshot():
            relatives = self._best_of(question, self._local_words, supported, SUPPORTED)
        return Sharing(scales, relatives)

    def _most_supported(
        self, index: WordIndex, examples: Examples, weights: list[NDArray[np.float32]]
    ) -> list[tuple[int, int]]:
        """Find the best pairs of a shape's id and a scale of a sample of the query."""
        pairs = []
        for query, rows in zip(examples.queries, weights, strict=True):
            ranks: dict[int, dict[int, int]] = {}
            for scale, shape_ids in enumerate(index.nearest(rows, LOCAL_CANDIDATES)):
                for rank, shape_id in enumerate(shape_ids.tolist()):
                    ranks.setdefault(shape_id, {})[scale] = rank
            found = stored_supports(self._store, self._model, query.shared, ranks)
            # Removed since their words were read.
            index.discard(set(ranks).difference(found))
            pairs += [
                (-float(found[shape_id][scale]) * (1 + rank / RANK_UNIT) ** -RANK_POWER, shape_id, scale)
                for shape_id in found
                for scale, rank in ranks[shape_id].items()
            ]
        return [(shape_id, scale) for _, shape_id, scale in sorted(pairs)[:SUPPORTED]]

    def _views(self, question: Question, matches: Sequence[Match]) -> dict[int, int]:
        """Which of the samples each match is compared with, by shape id."""
        shape_ids, bags = self._store.bags([match.shape_id for match in matches], self._model.bag_size)
        return dict(zip(shape_ids, question.nearest_samples(bags).tolist(), strict=True))

    def _scan(self, question: Question, top: int) -> list[Match]:
        best: list[Match] = []
        last_id = 0
        while True:
            # One snapshot for each portion: a writer must not wait until everything is compared.
            with self._store.snapshot():
                shape_ids, bags = self._store.bags_after(last_id, self._bags_at_once, self._model.bag_size)
                if not shape_ids:
                    return best
                best = self._merge(best, question, shape_ids, bags, top)
            last_id = shape_ids[-1]

    def _merge(
        self,
        best: list[Match],
        question: Question,
        shape_ids: list[int],
        bags: NDArray[np.float32],
        top: int,
    ) -> list[Match]:
        """Compare a portion of the library with the question and keep the `top` best seen so far."""
        distances = question.distances(bags)
        if len(distances) > top:
            # Equals of the last one stay in: their names decide, and names are read only for these few.
            chosen = np.flatnonzero(distances <= np.partition(distances, top - 1)[top - 1])
        else:
            chosen = np.arange(len(distances))
        records = self._store.shapes([shape_ids[position] for position in chosen])
        similarities = self._model.similarity(distances[chosen])
        matches = [
            Match(
                name=record.name,
                source=record.source,
                object_name=record.object_name,
                distance=float(distance),
                similarity=float(similarity),
                shape_id=record.shape_id,
                vertex_count=record.vertex_count,
                face_count=record.face_count,
                area=record.area,
            )
            for record, distance, similarity in zip(records, distances[chosen], similarities, strict=True)
        ]
        return heapq.nsmallest(top, [*best, *matches], key=lambda match: match.rank_key)


_I = TypeVar("_I", bound=ShapeIndex)


class _Codes(Generic[_I]):
    """One kind of codes of a store, read when first wanted; then only those that are new."""

    def __init__(self, store: Store, kind: CodeKind, code_bytes: int, empty: Callable[[], _I]) -> None:
        self._store = store
        self._kind = kind
        self._code_bytes = code_bytes
        self._empty = empty
        self._index: _I | None = None

    def current(self) -> _I:
        """All codes, with those that were added since they were read; some may be of shapes that are gone."""
        if self._index is None or self._index.gone > MAX_GONE:
            self._index = self._empty()
        for shape_ids, codes in self._store.code_pages(self._kind, self._index.last_id, self._code_bytes):
            self._index.add(shape_ids, codes)
        return self._index

    def forget(self) -> None:
        """Read all again next time."""
        self._index = None


def _compared(question: Question, top: int) -> int:
    """How many of the best by their bags are kept: those that geometry may bring forward too."""
    return max(top, SCREENED) if question.samples else top
