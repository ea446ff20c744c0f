# SPDX-License-Identifier: MIT
"""Fourth stage of a search: evidence, the kind of each of the best matches.

The search orders shapes by how likely they are the same. This stage finds what they have in common, see
`kinds`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.evidence import Evidence
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.evidence.figures import BagFigures, PairFigures, with_kind
from shapegoogle_core.library.search.evidence.kinds import Compared
from shapegoogle_core.library.search.evidence.placements import Placed, best_placement, shown_at
from shapegoogle_core.library.search.prepared import PreparedQueries
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.search.surfaces import stored_samples
from shapegoogle_core.library.search.verify import known_alignment
from shapegoogle_core.library.storage.signatures import unpack_measures
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["by_bags", "explain_matches"]


def explain_matches(
    store: Store,
    model: ShapeModel,
    queries: Sequence[ShapeSignature],
    matches: Sequence[Match],
    settings: SearchSettings,
    prepared: PreparedQueries,
    where: Filter | None = None,
) -> list[Match]:
    """Add evidence to matches, and give them the similarity of the pair.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    queries : sequence of ShapeSignature
        Examples of the query; each match is compared with the one nearest to it by its bags. Those without a
        sample are left out; those without their surface give coarser figures.
    matches : sequence of Match
        Alignments that verification found for them are used.
    settings : SearchSettings
    prepared : PreparedQueries
        Those of the library.
    where : Filter, optional
        Conditions of the search, which the chosen placements meet too.

    Returns
    -------
    matches : list of Match
        In their order; those with several placements as the one that fits best shows them. Without evidence:
        shapes without a sample, and shapes removed meanwhile.
    """
    usable = [(query, query.sample) for query in queries if query.sample is not None]
    if not usable or not matches:
        return by_bags(model, matches)
    certain = settings.verification.enough(
        several=len(queries) > 1, cut=any(sample.is_cut for _, sample in usable)
    )
    shape_ids = [match.shape_id for match in matches]
    by_id = {match.shape_id: match for match in matches}
    found, bags = store.bags(shape_ids, model.bag_size)
    distances = np.stack([model.distances(query.bags, bags) for query, _ in usable])
    nearest = dict(zip(found, distances.argmin(axis=0).tolist(), strict=True))
    least = dict(zip(found, distances.min(axis=0).tolist(), strict=True))
    typical = [model.typical_distances(query.bags, bags) for query, _ in usable]
    rows = {shape_id: row for row, shape_id in enumerate(found)}
    measures = unpack_measures(store, shape_ids)
    explained: dict[int, Match] = {}
    several = [match.shape_id for match in matches if match.placement_count > 1]
    placements = store.placements(several) if several else {}
    stored: defaultdict[int, list[Compared]] = defaultdict(list)
    for shape_id, sample in stored_samples(store, model, shape_ids):
        if shape_id in nearest:  # not removed meanwhile
            match = by_id[shape_id]
            if shape_id in placements:
                match = shown_at(match, placements[shape_id], 0)
            stored[nearest[shape_id]].append(Compared(sample, match, measures.get(shape_id)))
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        for example, group in stored.items():
            query, query_sample = usable[example]
            pair = PairFigures(model, settings, prepared.of(query), certain)
            shown = [cast(Match, compared.shape) for compared in group]
            bag_figures = [
                _bag_figures(match, least[match.shape_id], typical[example], rows[match.shape_id])
                for match in shown
            ]
            known = [known_alignment(match, query_sample) for match in shown]
            positions = pair.positions(group, bag_figures, known)
            for match, compared, figures, found_position in zip(
                shown, group, bag_figures, positions, strict=True
            ):
                shape_id, placed = match.shape_id, Placed(compared, found_position)
                similarities: list[float] = []
                explain = partial(_explain, pair, figures, similarities)
                if shape_id in placements:
                    objects = placements[shape_id]
                    evidence, position = best_placement(query_sample, placed, objects, explain, where)
                    best = shown_at(match, objects, position)
                else:
                    evidence, best = explain(placed), match
                similarity = max(similarities)
                evidence = with_kind(evidence, similarity, match.likeness)
                explained[shape_id] = replace(best, similarity=similarity, evidence=evidence)
    return [explained.get(match.shape_id) or replace(match, evidence=None) for match in matches]


def _bag_figures(match: Match, distance: float, typical: FloatArray | None, row: int) -> BagFigures:
    plain = None if typical is None else float(typical[row])
    if match.bag_distance is None:  # a match that is not of this search
        return BagFigures(distance, plain, distance, plain)
    return BagFigures(distance, plain, match.bag_distance, match.typical_distance)


def _explain(
    pair: PairFigures,
    bags: BagFigures,
    similarities: list[float],
    placed: Placed,
) -> Evidence:
    """Find the evidence at one placement, and note the similarity there."""
    similarity, evidence = pair.figures(placed.compared, bags, placed.position)
    similarities.append(similarity)
    return evidence


def by_bags(model: ShapeModel, matches: Sequence[Match]) -> list[Match]:
    """Give matches that are not explained the similarity of their bags.

    Parameters
    ----------
    model : ShapeModel
    matches : sequence of Match

    Returns
    -------
    matches : list of Match
    """
    return [
        match
        if match.bag_distance is None
        else replace(match, similarity=float(model.similarity(match.bag_distance, match.typical_distance)))
        for match in matches
    ]
