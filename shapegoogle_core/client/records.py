# SPDX-License-Identifier: MIT
"""From the JSON of a service to the records of a library."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any, get_args

import numpy as np

from shapegoogle_core.client.places import Places
from shapegoogle_core.client.values import one_of, real, text
from shapegoogle_core.library.decisions.decision import DECISION_KINDS, Decision, ShapeKey
from shapegoogle_core.library.duplicates.groups import DuplicateGroup, DuplicateMember
from shapegoogle_core.library.evidence import KINDS, Evidence
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.origin import SHAPE_TYPES, Origin
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.library.suggestions import Suggestion
from shapegoogle_core.library.suggestions.suggest import SuggestionKind

__all__ = ["decision_from", "group_from", "match_from", "placement_from", "shape_from", "suggestion_from"]

Record = Mapping[str, Any]


def match_from(record: Record, places: Places) -> Match:
    """Make a match.

    Parameters
    ----------
    record : mapping
        A `MatchRecord` of the service; a KeyError, TypeError or ValueError means that it is none.
    places : Places

    Returns
    -------
    match : Match
    """
    evidence, matrix, likeness = record["evidence"], record["placement"], record["likeness"]
    object_name = text(record["object_name"])
    return Match(
        name=text(record["name"]),
        source=places.source(record["source"]),
        object_name=object_name,
        distance=real(record["distance"]),
        similarity=real(record["similarity"]),
        shape_id=int(record["shape_id"]),
        vertex_count=int(record["vertices"]),
        face_count=int(record["faces"]),
        area=real(record["area"]),
        placement_count=int(record["placements"]),
        placement=None if matrix is None else Placement(object_name, _matrix(matrix)),
        versions=int(record["versions"]),
        version_ids=tuple(int(number) for number in record["version_ids"]),
        tags=tuple(text(tag) for tag in record["tags"]),
        origin=_origin(record),
        evidence=None if evidence is None else _evidence(evidence),
        likeness=None if likeness is None else real(likeness),
    )


def shape_from(record: Record, places: Places) -> ShapeRecord:
    """Make the record of a shape, of a `ShapeDetails` of the service; see `match_from`."""
    x, y, z = (real(extent) for extent in record["extents"])
    return ShapeRecord(
        shape_id=int(record["shape_id"]),
        name=text(record["name"]),
        source=places.source(record["source"]),
        object_name=text(record["object_name"]),
        vertex_count=int(record["vertices"]),
        face_count=int(record["faces"]),
        area=real(record["area"]),
        extents=(x, y, z),
        tags=tuple(text(tag) for tag in record["tags"]),
        placement_count=int(record["placements"]),
        origin=_origin(record),
    )


def placement_from(record: Record) -> Placement:
    """Make a placement, of a `PlacementRecord` of the service; see `match_from`."""
    extents = record["extents"]
    if extents is not None:
        x, y, z = (real(extent) for extent in extents)
        extents = x, y, z
    return Placement(text(record["object_name"]), _matrix(record["matrix"]), extents)


def group_from(record: Record, places: Places) -> DuplicateGroup:
    """Make a group of duplicates, of a `DuplicateRecord` of the service; see `match_from`."""
    members = tuple(
        DuplicateMember(
            name=text(member["name"]),
            source=places.source(member["source"]),
            object_name=text(member["object_name"]),
            shape_id=int(member["shape_id"]),
            similarity=real(member["similarity"]),
            scale=real(member["scale"]),
            placements=int(member["placements"]),
        )
        for member in record["members"]
    )
    saving = record["saving"]
    return DuplicateGroup(
        text(record["kind"]), members, real(record["similarity"]), int(saving["faces"]), int(saving["bytes"])
    )


def suggestion_from(record: Record) -> Suggestion:
    """Make a suggestion; see `match_from`."""
    relatives = tuple(text(name) for name in record["relatives"])
    kind = one_of(get_args(SuggestionKind), record["kind"])
    return Suggestion(kind, text(record["text"]), real(record["confidence"]), relatives)


def decision_from(record: Record) -> Decision:
    """Make a decision, of a `DecisionRecord` of the service; see `match_from`."""
    other = record["other"]
    return Decision(
        kind=one_of(DECISION_KINDS, record["kind"]),
        shape=_key(record["shape"]),
        other=None if other is None else _key(other),
        tag=text(record["tag"]),
        author=text(record["author"]),
        time=datetime.fromisoformat(record["time"]).timestamp(),
        number=int(record["number"]),
    )


def _origin(record: Record) -> Origin:
    frame = record["frame"]
    kind = one_of(SHAPE_TYPES, record["shape_type"])
    return Origin(kind, text(record["catalog"]), None if frame is None else int(frame))


def _evidence(record: Record) -> Evidence:
    figures = {name: real(value) for name, value in record.items() if name != "kind" and value is not None}
    return Evidence(one_of(KINDS, record["kind"]), **figures)


def _key(record: Record) -> ShapeKey:
    return ShapeKey(**{name: text(value) for name, value in record.items()})


def _matrix(values: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([real(value) for value in values]).reshape(4, 4)
