# SPDX-License-Identifier: MIT
"""Kinds of copies, from the measures of two meshes alone."""

from __future__ import annotations

from shapegoogle_core.library.evidence import EvidenceKind
from shapegoogle_core.registration import (
    MeshMeasures,
    handed_alike,
    is_same_mesh,
    is_same_place,
    is_same_size,
)

__all__ = ["copy_kind"]


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
