# SPDX-License-Identifier: MIT
"""`Match`: a shape of a library that a query finds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from shapegoogle_core.library.evidence import Evidence
from shapegoogle_core.library.origin import UNKNOWN, Origin
from shapegoogle_core.library.placement import Placement

if TYPE_CHECKING:
    from shapegoogle_core.registration import Alignment

__all__ = ["DISTANCE_DECIMALS", "Match", "ranked", "typical_distances"]

DISTANCE_DECIMALS = 6
"""Decimals that distances are rounded to. Half floats and the order of sums in a matrix product change later
digits: unrounded, copies of one shape would come in an unpredictable order."""


@dataclass(frozen=True)
class Match:
    """A shape of a library that a query finds.

    Attributes
    ----------
    name : str
        Name of the object or of the file.
    source : str
        Path of the file the shape comes from; empty for a shape added without one.
    object_name : str
        Name of the object inside the source, that of `placement` if several share the mesh; empty for a file
        that is one shape.
    distance : float
        What matches are sorted by, at least 0. Searched for by shape, it is the distance of the bags of query
        and shape, as the model measures it, lowered where the two surfaces fit; 0 for the same bags.
        Searched for by kind, it is a weighted sum of distances of bags, pictures and simple measures. For
        both, the latter is lowered where the former is small for such shapes, see
        `shapegoogle_core.model.ranking`. It is also lowered where a walk over neighbours leads from the query
        to the shape.
    similarity : float
        Confidence that it is the same shape, from 0 to 1. With evidence it depends on the two shapes and the
        model only: on their bags if these are certain, otherwise also on how well the surfaces fit. Without
        evidence it is that of the bags alone.
    likeness : float or None
        Confidence that it is of the same kind, such as another chair, from 0 to 1; a function of the two
        shapes and the model only. None if the model has not learnt about kinds.
    shape_id : int
        Number of the shape in its library; never given to another shape of that library.
    vertex_count, face_count : int
        Of the mesh as it was read.
    area : float
        Of the mesh as it was read, in squared units of its file.
    placement_count : int
        Number of objects that show the shape; 1 for a file without objects.
    placement : Placement or None
        The object that fits the query best, chosen with the evidence where several share the mesh.
    versions : int
        Number of other shapes of the same family that a search with ``families=True`` has met; there may be
        more.
    version_ids : tuple of int
        Their numbers, best first; see `Library.versions`.
    tags : tuple of str
        In alphabetical order.
    origin : Origin
        What it is in its file: its type, catalog and frame.
    evidence : Evidence or None
        Relation of the two surfaces, such as "re-posed"; None where they were not compared.
    bag_distance : float or None
        Distance of the bags; `distance` may have been lowered.
    bent_distance : float or None
        `distance` where local heat has changed it or agrees, see `PreparedSample.bent`.
    typical_distance : float or None
        Of unrelated shapes that are as plain as query and match, see `ShapeModel.typical_distances`.
    alignment : Alignment or None
        From the query to the match, if the search has found one; `Library.explain` uses it again.
    aligned_sample : int
        Checksum of the query's sample that was aligned, see `known_alignment`.

    Examples
    --------
    >>> import trimesh
    >>> import shapegoogle_core as sg
    >>> match = sg.compare(trimesh.creation.box(), trimesh.creation.box())
    >>> match.distance, match.similarity, match.evidence.kind
    (0.0, 1.0, 'identical')
    """

    name: str
    source: str
    object_name: str
    distance: float
    similarity: float
    shape_id: int
    vertex_count: int
    face_count: int
    area: float
    placement_count: int = 1
    placement: Placement | None = None
    versions: int = 0
    version_ids: tuple[int, ...] = field(default=(), repr=False)
    tags: tuple[str, ...] = ()
    origin: Origin = UNKNOWN
    evidence: Evidence | None = None
    likeness: float | None = None
    bag_distance: float | None = field(default=None, compare=False, repr=False)
    bent_distance: float | None = field(default=None, compare=False, repr=False)
    typical_distance: float | None = field(default=None, compare=False, repr=False)
    alignment: Alignment | None = field(default=None, compare=False, repr=False)
    aligned_sample: int = field(default=0, compare=False, repr=False)

    @property
    def rank_key(self) -> tuple[float, str, str, str, int]:
        """Key that sorts matches: by distance, then by name, source, object name and number."""
        return (self.distance, self.name, self.source, self.object_name, self.shape_id)

    def relative_size(self, query_area: float) -> float:
        """Return the size of the match relative to the query.

        Parameters
        ----------
        query_area : float
            Of the query's mesh as it was read.

        Returns
        -------
        size : float
            That of the evidence, where there is one: a part that lies on its whole has the size at which it
            does. Otherwise the square root of the ratio of the areas.

        Examples
        --------
        >>> import trimesh
        >>> import shapegoogle_core as sg
        >>> small, large = trimesh.creation.box(), trimesh.creation.box(extents=(3, 3, 3))
        >>> sg.compare(small, large).relative_size(small.area)
        3.0
        """
        if self.evidence is not None:
            return self.evidence.factor
        return math.sqrt(self.area / query_area) if query_area > 0 else 1.0

    def to_json(self) -> dict[str, object]:
        """Convert to the object that ``shapegoogle query --json`` prints.

        Returns
        -------
        record : dict
            ``name``, ``source``, ``object_name``, ``similarity``, ``likeness`` (a number or None),
            ``distance``, ``evidence`` (an object or None) and ``placements`` (their number); ``placement``,
            the matrix of the object that fits best, row by row, where one was chosen; ``versions`` where a
            family has any; ``shape_type``, and where there are any, ``tags``, ``catalog`` and ``frame``.
        """
        record: dict[str, object] = {
            "name": self.name,
            "source": self.source,
            "object_name": self.object_name,
            "similarity": round(self.similarity, 6),
            "likeness": None if self.likeness is None else round(self.likeness, 6),
            "distance": self.distance,
            "evidence": None if self.evidence is None else self.evidence.to_json(),
            "placements": self.placement_count,
            "shape_type": self.origin.completed(self.object_name).shape_type,
        }
        if self.tags:
            record["tags"] = list(self.tags)
        if self.origin.catalog:
            record["catalog"] = self.origin.catalog
        if self.origin.frame is not None:
            record["frame"] = self.origin.frame
        if self.placement is not None:
            record["placement"] = self.placement.matrix.ravel().tolist()
        if self.versions:
            record["versions"] = self.versions
        return record


def typical_distances(matches: Sequence[Match]) -> list[float] | None:
    """Return the typical distances of matches, for `ShapeModel.similarity`.

    Parameters
    ----------
    matches : sequence of Match
        Of one search.

    Returns
    -------
    typical : list of float or None
        None for matches of a model without a background.
    """
    known = [match.typical_distance for match in matches if match.typical_distance is not None]
    return known if len(known) == len(matches) else None


def ranked(match: Match, distance: float, likeness: float | None) -> Match:
    """Return a match with another distance and likeness; a search makes hundreds of these.

    Parameters
    ----------
    match : Match
    distance : float
    likeness : float or None

    Returns
    -------
    match : Match
    """
    if distance == match.distance and likeness == match.likeness:
        return match
    # `dataclasses.replace` takes ten times as long.
    other = Match.__new__(Match)
    other.__dict__.update(match.__dict__, distance=distance, likeness=likeness)
    return other
