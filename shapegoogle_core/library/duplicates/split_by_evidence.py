# SPDX-License-Identifier: MIT
"""Evidence for groups of duplicates: exact copies are told from other meshes, poses and parts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

from threadpoolctl import threadpool_limits

from shapegoogle_core.library.duplicates.groups import DuplicateGroup, DuplicateMember, largest_saving_first
from shapegoogle_core.library.duplicates.settings import EXPLAINED_MEMBERS
from shapegoogle_core.library.duplicates.similar import distance_at
from shapegoogle_core.library.search.kinds import Compared, Explainer
from shapegoogle_core.library.search.surfaces import stored_samples
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel

__all__ = ["split_by_evidence"]

# Groups whose samples are in memory at once.
_PAGE = 200


def split_by_evidence(
    store: Store, model: ShapeModel, groups: Sequence[DuplicateGroup], explained: int = EXPLAINED_MEMBERS
) -> list[DuplicateGroup]:
    """Split groups by the evidence of their members.

    Copies of a mesh with its vertices in the same order are recognised at once, so all members are checked
    for that. Aligning other members takes longer; it is done in the order of the savings, up to a maximum
    number, and the rest of the members stay "same" or "similar".

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
    if model.settings.sample is None:
        return largest_saving_first([*split, *uncertain])
    left = explained
    with threadpool_limits(1, user_api="blas"):
        for start in range(0, len(uncertain), _PAGE):
            page = uncertain[start : start + _PAGE]
            wanted = [member.shape_id for group in page for member in group.members]
            records = {record.shape_id: record for record in store.shapes(wanted)}
            for group in page:
                known = _compared(store, model, group, records)
                parts, used = _split(model, group, known, left)
                split += parts
                left -= used
    return largest_saving_first(split)


def _compared(
    store: Store, model: ShapeModel, group: DuplicateGroup, records: dict[int, ShapeRecord]
) -> dict[int, Compared]:
    """Read samples and counts of the members of a group, without members that were removed meanwhile."""
    there = [member.shape_id for member in group.members if member.shape_id in records]
    return {
        shape_id: Compared(sample, records[shape_id])
        for shape_id, sample in stored_samples(store, model, there)
    }


def _split(
    model: ShapeModel, group: DuplicateGroup, known: dict[int, Compared], left: int
) -> tuple[list[DuplicateGroup], int]:
    """Split a group, and count the members that were aligned to the first one."""
    first = group.members[0]
    if first.shape_id not in known:
        return [group], 0
    explainer = Explainer(known[first.shape_id])
    kinds: defaultdict[str, list[DuplicateMember]] = defaultdict(list)
    faces: defaultdict[str, int] = defaultdict(int)
    used = 0
    for member in group.members[1:]:
        kind = group.kind
        compared = known.get(member.shape_id)
        if compared is not None:
            evidence = explainer.copy(compared)
            if evidence is None and used < left:
                distance = distance_at(model, max(member.similarity, 1e-9))
                evidence = explainer.explain(compared, member.similarity, distance)
                used += 1
            if evidence is not None:
                kind = evidence.kind
                member = replace(member, scale=evidence.factor)
            faces[kind] += compared.shape.face_count
        kinds[kind].append(member)
    parts = [
        DuplicateGroup(
            kind=kind,
            members=(first, *members),
            similarity=min(member.similarity for member in members),
            saved_faces=faces[kind],
        )
        for kind, members in kinds.items()
    ]
    return parts, used
