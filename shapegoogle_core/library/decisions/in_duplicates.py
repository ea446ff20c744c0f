# SPDX-License-Identifier: MIT
"""Decisions in lists of duplicates: pairs that are both kept, and masters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shapegoogle_core.library.decisions.decision import Decision
from shapegoogle_core.library.duplicates.groups import DuplicateGroup, DuplicateMember, largest_saving_first
from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel, row_distances

__all__ = ["follow_decisions"]


def follow_decisions(
    store: Store, model: ShapeModel, groups: Sequence[DuplicateGroup], decisions: Sequence[Decision]
) -> list[DuplicateGroup]:
    """Put masters first in their groups, and leave out shapes that are kept beside another one.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        The model that described the shapes.
    groups : sequence of DuplicateGroup
        From `find_duplicates`, before their surfaces are compared.
    decisions : sequence of Decision
        All of the library, oldest first.

    Returns
    -------
    groups : list of DuplicateGroup
        The largest saving first. Of two shapes that are both kept, the one that comes first stays in the
        group. Of several masters in a group the one that was chosen last counts.
    """
    masters = store.shapes_of([decision.shape for decision in decisions if decision.kind == "master"])
    pairs = [(made.shape, made.other) for made in decisions if made.kind == "keep both" and made.other]
    first, second = (store.shapes_of([pair[side] for pair in pairs]) for side in (0, 1))
    kept = {frozenset(pair) for pair in zip(first, second, strict=True) if None not in pair}
    if not kept and not masters:
        return list(groups)
    concerned = {number for pair in kept for number in pair} | set(masters)
    changed = [
        group
        if concerned.isdisjoint(member.shape_id for member in group.members)
        else _regrouped(store, model, group, masters, kept)
        for group in groups
    ]
    return largest_saving_first([group for group in changed if group is not None])


def _regrouped(
    store: Store,
    model: ShapeModel,
    group: DuplicateGroup,
    masters: Sequence[int | None],
    kept: set[frozenset[int | None]],
) -> DuplicateGroup | None:
    """Make the group again; None if less than two shapes are left."""
    place = {number: position for position, number in enumerate(masters)}
    ordered = sorted(group.members, key=lambda member: -place.get(member.shape_id, -1))
    members: list[DuplicateMember] = []
    for member in ordered:
        if all(frozenset((member.shape_id, other.shape_id)) not in kept for other in members):
            members.append(member)
    if len(members) < 2:
        return None
    if group.kind == "copies":  # equal files: each saves as much as another
        others = len(group.members) - 1
        return replace(
            group,
            members=tuple(members),
            saved_faces=group.saved_faces // others * (len(members) - 1),
            saved_bytes=group.saved_bytes // others * (len(members) - 1),
        )
    records = {record.shape_id: record for record in store.shapes([member.shape_id for member in members])}
    if members[0] is not group.members[0]:
        members = _compared_with_first(store, model, members)
    return replace(
        group,
        members=tuple(members),
        similarity=min(member.similarity for member in members),
        saved_faces=sum(
            records[member.shape_id].face_count for member in members[1:] if member.shape_id in records
        ),
    )


def _compared_with_first(
    store: Store, model: ShapeModel, members: Sequence[DuplicateMember]
) -> list[DuplicateMember]:
    """Give members the similarity and the size that they have relative to a new first one."""
    numbers, bags = store.bags([member.shape_id for member in members], model.bag_size)
    if members[0].shape_id not in numbers:  # removed by another program meanwhile
        return list(members)
    vectors = model.comparable(bags)
    first = vectors[numbers.index(members[0].shape_id)][None]
    metric = model.settings.metric
    away = np.round(row_distances(metric, first, vectors), DISTANCE_DECIMALS)
    if model.background is not None:
        plain = model.background.distances(metric, vectors)
        typical = np.sqrt(plain[numbers.index(members[0].shape_id)] * plain)
        away = model.weighed_distances(away, typical)
    similarity = dict(zip(numbers, model.similarity(away).tolist(), strict=True))
    return [
        replace(
            member,
            similarity=1.0 if member is members[0] else similarity.get(member.shape_id, member.similarity),
            scale=member.scale / members[0].scale if members[0].scale > 0 else 1.0,
        )
        for member in members
    ]
