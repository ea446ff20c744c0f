# SPDX-License-Identifier: MIT
"""`Match`: one line of an answer."""

from __future__ import annotations

from dataclasses import dataclass

from shapegoogle_core.library.evidence import Evidence

__all__ = ["DISTANCE_DECIMALS", "Match"]

# Distances are dimensionless and of order one. Half floats and the order in which a matrix product adds up
# move them in later digits; unrounded, copies of one shape would come in an order that nobody can foresee.
DISTANCE_DECIMALS = 6


@dataclass(frozen=True)
class Match:
    """A shape of the library that answers a query.

    Attributes
    ----------
    name : str
        The object's or the file's name.
    source : str
        Path of the file that the shape came from; empty when it was added without one.
    object_name : str
        Name of the object inside the source; empty for a file that is one shape.
    distance : float
        Between the bags of query and shape, as the model measures it; 0 for the same bag. Less where the two
        surfaces were laid over one another and agree.
    similarity : float
        The model's monotone reading of the distance: 1 at distance 0, towards 0 for shapes that have nothing
        in common.
    shape_id : int
        The shape's number in its library; never given to another shape of that library.
    vertex_count : int
        Of the mesh as it was read.
    face_count : int
        Of the mesh as it was read.
    area : float
        Of the mesh as it was read, in squared units of its file.
    evidence : Evidence or None
        Relation of the two surfaces, such as "re-posed"; None where they were not compared.
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
    evidence: Evidence | None = None

    @property
    def rank_key(self) -> tuple[float, str, str, str, int]:
        """What matches are sorted by: distance first; the rest decides between equals."""
        return (self.distance, self.name, self.source, self.object_name, self.shape_id)

    def to_json(self) -> dict[str, object]:
        """Put the match into the form that ``shapegoogle query --json`` prints.

        Returns
        -------
        record : dict
            ``name``, ``source``, ``similarity``, ``distance`` and ``evidence`` (an object or None).
        """
        return {
            "name": self.name,
            "source": self.source,
            "similarity": round(self.similarity, 6),
            "distance": self.distance,
            "evidence": None if self.evidence is None else self.evidence.to_json(),
        }
