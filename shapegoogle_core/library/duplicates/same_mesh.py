# SPDX-License-Identifier: MIT
"""Copies of meshes among many shapes, by their measures."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import numpy as np

from shapegoogle_core.registration import MeshMeasures, is_same_mesh

__all__ = ["group_copies"]

# More than the largest difference of a moment of two copies: a first selection.
_WINDOW = 1e-4


def group_copies(measures: Mapping[int, MeshMeasures]) -> list[list[int]]:
    """Group shapes whose meshes are copies of each other, whatever their places and sizes.

    Parameters
    ----------
    measures : mapping of int to MeshMeasures
        By shape id.

    Returns
    -------
    groups : list of list of int
        Ids in ascending order, two or more; each is a copy of the first.
    """
    by_counts: defaultdict[tuple[int, int], list[int]] = defaultdict(list)
    for shape_id in sorted(measures):
        by_counts[measures[shape_id].vertex_count, measures[shape_id].face_count].append(shape_id)
    groups = []
    for shape_ids in by_counts.values():
        if len(shape_ids) < 2:
            continue
        spread = np.array([measures[shape_id].fourth for shape_id in shape_ids])
        order = np.argsort(spread, kind="stable")
        low = np.searchsorted(spread[order], spread - _WINDOW)
        high = np.searchsorted(spread[order], spread + _WINDOW)
        free = np.ones(len(shape_ids), bool)
        for position, shape_id in enumerate(shape_ids):
            if not free[position]:
                continue
            free[position] = False
            near = np.sort(order[low[position] : high[position]])
            own = measures[shape_id]
            found = [other for other in near[free[near]] if is_same_mesh(own, measures[shape_ids[other]])]
            free[found] = False
            if found:
                groups.append([shape_id, *(shape_ids[other] for other in found)])
    return groups
