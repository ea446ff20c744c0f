# SPDX-License-Identifier: MIT
"""Kinds of copies, from the measures of two meshes alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import islice, product

import numpy as np

from shapegoogle_core.library.evidence import EvidenceKind
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.storage.signatures import unpack_measures
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import (
    MeshMeasures,
    handed_alike,
    is_same_mesh,
    is_same_place,
    is_same_size,
)

__all__ = ["copies_first", "copy_kind", "placed_copy_kind"]

# Digits of the logarithm of a scale by which placements of one size are recognised.
_SCALE_DIGITS = 5


def copy_kind(query: MeshMeasures | None, match: MeshMeasures | None) -> tuple[EvidenceKind, float] | None:
    """Decide how a mesh is a copy of the query's.

    Parameters
    ----------
    query, match : MeshMeasures or None
        None if they are not known.

    Returns
    -------
    kind, factor : str, float
        "identical", "moved", "scaled" or "mirrored", and the size relative to the query; a mesh that is its
        own mirror image is never "mirrored". None if the match is no copy, or if that is not known.
    """
    if query is None or match is None or not is_same_mesh(query, match):
        return None
    factor = 1.0 if is_same_size(query, match) else match.unit / query.unit
    if is_same_place(query, match):
        return "identical", factor
    if handed_alike(query, match) is False:
        return "mirrored", factor
    return "moved" if factor == 1 else "scaled", factor


def placed_copy_kind(
    query: MeshMeasures | None,
    match: MeshMeasures | None,
    query_placements: Sequence[Placement] = (),
    match_placements: Sequence[Placement] = (),
) -> tuple[EvidenceKind, float] | None:
    """Decide how a mesh is a copy of the query's, at the placements of both that agree best.

    Parameters
    ----------
    query, match : MeshMeasures or None
        At the first placements.
    query_placements, match_placements : sequence of Placement, optional
        All placements of each; one of each size and handedness is compared.

    Returns
    -------
    kind, factor : str, float
        See `copy_kind`.
    """
    found = copy_kind(query, match)
    if (
        found is None
        or query is None
        or match is None
        or max(map(len, (query_placements, match_placements))) < 2
    ):
        return found
    pairs = product(_at_placements(query, query_placements), _at_placements(match, match_placements))
    kinds = [copy_kind(one, other) for one, other in islice(pairs, 1, None)]  # the first pair is known
    return min((found, *(kind for kind in kinds if kind is not None)), key=_closeness)


def _at_placements(measures: MeshMeasures, placements: Sequence[Placement]) -> list[MeshMeasures]:
    """Carry the measures at the first placement to one placement of each size and handedness."""
    chosen: dict[tuple[float, bool], Placement] = {}
    for placement in placements:
        size = round(math.log(placement.scale), _SCALE_DIGITS)
        chosen.setdefault((size, placement.is_mirrored), placement)
    if not chosen:
        return [measures]
    back = np.linalg.inv(placements[0].matrix)
    others = [placement for placement in chosen.values() if placement is not placements[0]]
    return [measures, *(measures.moved(placement.matrix @ back) for placement in others)]


def _closeness(kind: tuple[EvidenceKind, float]) -> tuple[int, float]:
    rank = {"identical": 0, "mirrored": 2}.get(kind[0], 1)
    return rank, abs(math.log(kind[1]))


def copies_first(store: Store, queries: Sequence[ShapeSignature], matches: Sequence[Match]) -> list[Match]:
    """Order the matches that share the least distance: identical ones first, then other copies, then by name.

    Parameters
    ----------
    store : Store
    queries : sequence of ShapeSignature
        Examples that were searched for.
    matches : sequence of Match
        Best first.

    Returns
    -------
    matches : list of Match
    """
    tied = [match for match in matches if match.distance == matches[0].distance]
    if len(tied) < 2:
        return list(matches)
    measures = unpack_measures(store, [match.shape_id for match in tied])

    def rank(match: Match) -> int:
        kinds = [copy_kind(query.measures, measures.get(match.shape_id)) for query in queries]
        if any(kind is not None and kind[0] == "identical" for kind in kinds):
            return 0
        return 1 if any(kind is not None for kind in kinds) else 2

    ordered = sorted(tied, key=lambda match: (rank(match), match.rank_key))
    return [*ordered, *(match for match in matches if match.distance != matches[0].distance)]
