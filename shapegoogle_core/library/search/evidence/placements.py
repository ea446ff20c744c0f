# SPDX-License-Identifier: MIT
"""Choice of the placement that fits a query best, among the objects that show one shape.

The surface of a shape is stored once, as its first placement shows it; R_i = M_i M_0⁻¹ carries it to
placement i. A placement that lies where the query does is explained first, because it may be identical. Else
the one of the nearest size is. Its evidence holds for all others too: sizes multiply and reflections cancel,
so another placement is explained only if it must fit better.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shapegoogle_core.library.evidence import Evidence
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.search.evidence.figures import Position
from shapegoogle_core.library.search.evidence.kinds import Compared
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration import SurfaceSample

__all__ = ["Placed", "best_placement", "shown_at"]

# Largest difference of size and place, relative to the query, of a placement that may lie where it does.
_NEAR = 0.05
# Number of points whose places are compared.
_POINTS = 48
# Relative difference of sizes that counts.
_SIZE = 1e-3
# Kinds of evidence that are the same for all placements but for the size.
_WITHOUT_PLACE = ("re-posed", "similar")


@dataclass(frozen=True, eq=False)
class Placed:
    """A shape as the query may see it: at one of its placements.

    Attributes
    ----------
    compared : Compared
    position : Position or None
        How the shape and the query lie on each other, where it is known.
    """

    compared: Compared
    position: Position | None


Explain = Callable[[Placed], Evidence]


def best_placement(
    query: SurfaceSample,
    stored: Placed,
    placements: Sequence[Placement],
    explain: Explain,
    where: Filter | None = None,
) -> tuple[Evidence, int]:
    """Find the placement that fits the query best, and its evidence.

    Parameters
    ----------
    query : SurfaceSample
    stored : Placed
        The shape as it is stored, that is at its first placement.
    placements : sequence of Placement
        At least one.
    explain : callable
        Finds the evidence of the shape at a placement.
    where : Filter, optional
        Only placements that meet its name, size and area are chosen, if there are any.

    Returns
    -------
    evidence : Evidence
    position : int
        Of the placement.
    """
    chosen = every = list(range(len(placements)))
    if where is not None:
        areas = [
            stored.compared.shape.area * (placed.scale / placements[0].scale) ** 2 for placed in placements
        ]
        chosen = [index for index in every if where.accepts(placements[index], areas[index])]
    matrices = np.stack([placements[index].matrix for index in chosen or every])
    relative = matrices @ np.linalg.inv(placements[0].matrix)
    scales = np.sqrt((relative[:, :3, :3] ** 2).sum(axis=(1, 2)) / 3)
    flipped = np.linalg.det(relative[:, :3, :3]) < 0

    def explained(position: int) -> tuple[Evidence, int]:
        return explain(_placed(stored, relative[position])), position

    sample = stored.compared.sample
    first = _in_place(query, sample, relative, scales)
    found = explained(_nearest(query, sample, relative, scales, flipped) if first is None else first)
    evidence, position = found
    sizes = np.abs(np.log(evidence.factor * scales / scales[position]))
    if evidence.kind in _WITHOUT_PLACE:
        # Only a part of the mirror image would be missed.
        others = [_least(sizes, flipped != flipped[position])]
    else:
        mirrored = (flipped != flipped[position]) != (evidence.kind == "mirrored")
        same, other = _least(sizes, ~mirrored), _least(sizes, mirrored)
        others = []
        if same is not None and (mirrored[position] or sizes[same] + _SIZE < sizes[position]):
            others.append(same)
        # Not mirrored after all, if the shape is its own mirror image.
        if other is not None and sizes[other] + _SIZE < sizes[position if same is None else same]:
            others.append(other)
    tried = [found, *(explained(other) for other in others if other is not None and other != position)]
    evidence, position = min(tried, key=lambda pair: _rank(pair[0]))
    if evidence.kind in _WITHOUT_PLACE:
        best = int(sizes.argmin())
        if sizes[best] + _SIZE < sizes[position]:
            factor = evidence.factor * scales[best] / scales[position]
            evidence, position = replace(evidence, factor=float(f"{factor:.4g}")), best
    return evidence, (chosen or every)[position]


def _least(sizes: FloatArray, among: NDArray[np.bool_]) -> int | None:
    """Find the least of some sizes, the first of equal ones."""
    return int(np.flatnonzero(among)[sizes[among].argmin()]) if among.any() else None


def shown_at(match: Match, placements: Sequence[Placement], position: int) -> Match:
    """Let a match stand for one of its placements.

    Parameters
    ----------
    match : Match
        At any placement.
    placements : sequence of Placement
    position : int

    Returns
    -------
    match : Match
        With the name of the object and the area of that placement. A collection keeps its own name, under
        which it is appended, whatever object shows it.
    """
    chosen = placements[position]
    before = placements[0] if match.placement is None else match.placement
    area = match.area * (chosen.scale / before.scale) ** 2
    name = match.object_name if match.origin.shape_type == "collection" else chosen.object_name
    return replace(match, placement=chosen, object_name=name, area=area)


def _rank(evidence: Evidence) -> tuple[int, float]:
    """Order evidence of one pair of shapes: identical, then not mirrored, then the nearest size."""
    ranks = {"identical": 0, "mirrored": 2, "re-posed": 3, "similar": 4}
    return ranks.get(evidence.kind, 1), abs(math.log(evidence.factor))


def _placed(stored: Placed, relative: FloatArray) -> Placed:
    """Carry a stored shape to a placement."""
    if np.array_equal(relative, np.eye(4)):
        return stored
    shape, sample, measures = stored.compared.shape, stored.compared.sample, stored.compared.measures
    scale = float(np.sqrt((relative[:3, :3] ** 2).sum() / 3))
    rotation = relative[:3, :3] / scale
    turned = sample.placed(relative)
    compared = Compared(
        turned,
        replace(shape, area=scale**2 * shape.area),
        None if measures is None else measures.moved(relative),
    )
    position = stored.position
    if position is None or np.linalg.det(rotation) < 0:
        return Placed(compared, None)
    return Placed(compared, position.turned(turned, rotation))


def _in_place(
    query: SurfaceSample, stored: SurfaceSample, relative: FloatArray, scales: FloatArray
) -> int | None:
    """Find the placement whose points lie nearest to those of the query; None if none lies there."""
    centers = relative[:, :3, :3] @ stored.center + relative[:, :3, 3]
    apart = np.linalg.norm(centers - query.center, axis=1) / query.unit
    near = np.flatnonzero((apart <= _NEAR) & (np.abs(np.log(scales * stored.unit / query.unit)) <= _NEAR))
    if len(near) == 0:
        return None
    tree = cKDTree(query.center + query.unit * query.points)
    points = stored.center + stored.unit * stored.points[:_POINTS]
    placed = np.einsum("nij,pj->npi", relative[near, :3, :3], points) + relative[near, None, :3, 3]
    distances = np.asarray(tree.query(placed)[0]).mean(axis=1) / query.unit
    return int(near[distances.argmin()]) if distances.min() <= _NEAR else None


def _nearest(
    query: SurfaceSample,
    stored: SurfaceSample,
    relative: FloatArray,
    scales: FloatArray,
    flipped: NDArray[np.bool_],
) -> int:
    """Find the placement of the nearest size; among several one that is not mirrored, then the nearest."""
    sizes = np.round(np.abs(np.log(scales * stored.unit / query.unit)) / _SIZE)
    centers = relative[:, :3, :3] @ stored.center + relative[:, :3, 3]
    return int(np.lexsort((np.linalg.norm(centers - query.center, axis=1), flipped, sizes))[0])
