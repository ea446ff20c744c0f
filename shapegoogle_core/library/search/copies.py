# SPDX-License-Identifier: MIT
"""Kinds of copies, from the measures of two meshes alone."""

from __future__ import annotations

from collections.abc import Sequence

from shapegoogle_core.library.evidence import EvidenceKind
from shapegoogle_core.library.match import Match
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

__all__ = ["copies_first", "copy_kind"]


def copy_kind(query: MeshMeasures | None, match: MeshMeasures | None) -> tuple[EvidenceKind, float] | None:
    """Decide how a mesh is a copy of the query's.

    Parameters
    ----------
    query, match : MeshMeasures or None
        None if they are not known.

    Returns
    -------
    kind, factor : str, float
        "identical", "moved", "scaled" or "mirrored", and the size relative to the query; a shape that is its
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
