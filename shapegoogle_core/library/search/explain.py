# SPDX-License-Identifier: MIT
"""Fourth stage of a search: evidence, the kind of each of the best matches.

The search orders shapes by how likely they are the same. This stage finds what they have in common, see
`kinds`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.evidence import Evidence
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.kinds import Compared, Explainer
from shapegoogle_core.library.search.settings import EvidenceSettings
from shapegoogle_core.library.search.surfaces import stored_samples
from shapegoogle_core.library.search.verify import known_alignment
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import SurfaceSample

__all__ = ["MatchExplainer", "explain_matches"]


class MatchExplainer:
    """Explains matches by comparing their surfaces with those of the examples of a query.

    Parameters
    ----------
    queries : sequence of ShapeSignature
        Examples of the query, each with a sample; without their surface the figures are coarser.
    settings : EvidenceSettings
    """

    def __init__(self, queries: Sequence[ShapeSignature], settings: EvidenceSettings) -> None:
        self._queries = queries
        self._settings = settings
        self._explainers: dict[int, Explainer] = {}

    def explain(self, match: Match, sample: SurfaceSample, example: int, distance: float) -> Evidence:
        """Compare a match with an example, starting from the alignment of verification, if there is one.

        Parameters
        ----------
        match : Match
        sample : SurfaceSample
            Of the match.
        example : int
            Position of the example.
        distance : float
            Distance of the bags of both.

        Returns
        -------
        evidence : Evidence
        """
        query = self._queries[example]
        assert query.sample is not None  # see `queries`
        if example not in self._explainers:
            compared = Compared(query.sample, query.vertex_count, query.face_count, query.area)
            self._explainers[example] = Explainer(compared, query.surface, self._settings)
        compared = Compared(sample, match.vertex_count, match.face_count, match.area)
        alignment = known_alignment(match, query.sample)
        return self._explainers[example].explain(compared, match.similarity, distance, alignment)


def explain_matches(
    store: Store,
    model: ShapeModel,
    queries: Sequence[ShapeSignature],
    matches: Sequence[Match],
    settings: EvidenceSettings,
) -> list[Match]:
    """Add evidence to matches.

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
    settings : EvidenceSettings

    Returns
    -------
    matches : list of Match
        In their order. Without evidence: shapes without a sample, and shapes removed meanwhile.
    """
    usable = [query for query in queries if query.sample is not None]
    if not usable or not matches:
        return list(matches)
    shape_ids = [match.shape_id for match in matches]
    found, bags = store.bags(shape_ids, model.bag_size)
    distances = np.stack([model.distances(query.bags, bags) for query in usable])
    nearest = dict(zip(found, distances.argmin(axis=0).tolist(), strict=True))
    least = dict(zip(found, distances.min(axis=0).tolist(), strict=True))
    explainer = MatchExplainer(usable, settings)
    evidence: dict[int, Evidence] = {}
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        by_id = {match.shape_id: match for match in matches}
        for shape_id, sample in stored_samples(store, model, shape_ids):
            if shape_id in nearest:  # else it was removed meanwhile
                evidence[shape_id] = explainer.explain(
                    by_id[shape_id], sample, nearest[shape_id], least[shape_id]
                )
    return [replace(match, evidence=evidence.get(match.shape_id)) for match in matches]
