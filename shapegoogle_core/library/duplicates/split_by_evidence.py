# SPDX-License-Identifier: MIT
"""Evidence for groups of duplicates: exact copies are told from other meshes, poses and parts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

from threadpoolctl import threadpool_limits

from shapegoogle_core.library.duplicates.groups import (
    NOT_COMPARED,
    DuplicateGroup,
    DuplicateMember,
    largest_saving_first,
)
from shapegoogle_core.library.duplicates.settings import EXPLAINED_MEMBERS
from shapegoogle_core.library.duplicates.similar import distance_at
from shapegoogle_core.library.evidence import Evidence
from shapegoogle_core.library.search.evidence.copies import placed_copy_kind
from shapegoogle_core.library.search.evidence.kinds import Compared, Explainer
from shapegoogle_core.library.search.surfaces import stored_samples
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.library.storage.signatures import unpack_measures
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import MeshMeasures

__all__ = ["split_by_evidence"]

# Groups whose samples are in memory at once.
_PAGE = 200


def split_by_evidence(
    store: Store, model: ShapeModel, groups: Sequence[DuplicateGroup], explained: int = EXPLAINED_MEMBERS
) -> list[DuplicateGroup]:
    """Split groups by the evidence of their members.

    The kind of a copy follows from its measures at once. Aligning other members takes longer; it is done in
    the order of the savings, up to a maximum number. The rest are "not compared".

    Parameters
    ----------
    store : Store
    model : ShapeModel
        The model that described the shapes.
    groups : sequence of DuplicateGroup
        From `find_duplicates`.
    explained : int, optional
        Maximum number of members aligned to the first shape of their group.

    Returns
    -------
    groups : list of DuplicateGroup
        The largest saving first. A group may have become several, one for each kind of evidence, each with
        the same first member; groups of copied files stay as they are.
    """
    split = [group for group in groups if group.kind == "copies"]
    uncertain = [group for group in groups if group.kind != "copies"]
    left = explained
    with threadpool_limits(1, user_api="blas"):
        for start in range(0, len(uncertain), _PAGE):
            page = uncertain[start : start + _PAGE]
            wanted = [member.shape_id for group in page for member in group.members]
            records = {record.shape_id: record for record in store.shapes(wanted)}
            for group in page:
                parts, used = _split(store, model, group, records, left)
                split += parts
                left -= used
    return largest_saving_first(split)


def _split(
    store: Store, model: ShapeModel, group: DuplicateGroup, records: dict[int, ShapeRecord], left: int
) -> tuple[list[DuplicateGroup], int]:
    """Split a group, and count the members that were aligned to the first one."""
    first = group.members[0]
    measures = unpack_measures(store, [member.shape_id for member in group.members])
    placements = store.placements([member.shape_id for member in group.members])
    copies = {}
    for member in group.members[1:]:
        pair = first.shape_id, member.shape_id
        found = placed_copy_kind(
            measures.get(pair[0]),
            measures.get(pair[1]),
            placements.get(pair[0], ()),
            placements.get(pair[1], ()),
        )
        if found is not None:
            copies[member.shape_id] = found
    others = [member.shape_id for member in group.members[1:] if member.shape_id not in copies]
    explained = _explained(store, model, group, records, measures, others[:left])
    kinds: defaultdict[str, list[DuplicateMember]] = defaultdict(list)
    faces: defaultdict[str, int] = defaultdict(int)
    for member in group.members[1:]:
        kind, scale = NOT_COMPARED, member.scale
        if member.shape_id in copies:
            kind, scale = copies[member.shape_id]
        elif (evidence := explained.get(member.shape_id)) is not None:
            kind, scale = evidence.kind, evidence.factor
        if member.shape_id in records:
            faces[kind] += records[member.shape_id].face_count
        kinds[kind].append(replace(member, scale=scale))
    parts = [
        DuplicateGroup(
            kind=kind,
            members=(first, *members),
            similarity=min(member.similarity for member in members),
            saved_faces=faces[kind],
        )
        for kind, members in kinds.items()
    ]
    return parts, len(explained)


def _explained(
    store: Store,
    model: ShapeModel,
    group: DuplicateGroup,
    records: dict[int, ShapeRecord],
    measures: dict[int, MeshMeasures],
    shape_ids: Sequence[int],
) -> dict[int, Evidence]:
    """Align members of a group with its first one, as far as their surfaces are stored."""
    first = group.members[0].shape_id
    if model.settings.sample is None or not shape_ids or first not in records:
        return {}
    there = [shape_id for shape_id in (first, *shape_ids) if shape_id in records]
    known = {
        shape_id: Compared(sample, records[shape_id], measures.get(shape_id))
        for shape_id, sample in stored_samples(store, model, there)
    }
    if first not in known:
        return {}
    explainer = Explainer(known[first])
    similarity = {member.shape_id: member.similarity for member in group.members}
    return {
        shape_id: explainer.explain(known[shape_id], distance_at(model, max(similarity[shape_id], 1e-9)))
        for shape_id in shape_ids
        if shape_id in known
    }
