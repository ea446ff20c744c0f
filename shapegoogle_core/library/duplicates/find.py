# SPDX-License-Identifier: MIT
"""Search for duplicates in a library: copied files, the same shape again, and similar shapes."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import IO

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.duplicates.copied_files import copied_files, copy_group
from shapegoogle_core.library.duplicates.groups import DuplicateGroup, DuplicateMember, largest_saving_first
from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY, SAME_SIMILARITY
from shapegoogle_core.library.duplicates.shape_columns import read_columns
from shapegoogle_core.library.duplicates.similar import cluster_similar, distance_at
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["find_duplicates"]

# Bags read at once.
PAGE = 2_000


def find_duplicates(
    store: Store, model: ShapeModel, min_similarity: float = MIN_SIMILARITY, progress: Wrapper = iter
) -> list[DuplicateGroup]:
    """Find the groups of duplicates in a library.

    Copied files come first: of each set of equal files only the first takes part in the next steps. Then the
    same shapes are grouped around the oldest of them, and the remaining ones, one for each group, by
    similarity; see `leader_clustering` for the method and for pairs that its keys may miss. No shape is in
    two groups of one kind. The vectors that are compared lie in a temporary file; ``docs/library.md`` gives
    its size.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        The model that described the shapes.
    min_similarity : float
        Least similarity of a "similar" shape to the first of its group; 0 < min_similarity ≤ 1.
    progress : callable, optional
        Wraps the loop over the shapes, as tqdm does.

    Returns
    -------
    groups : list of DuplicateGroup
        The largest saving first: faces, then bytes.

    Raises
    ------
    ValueError
        If `min_similarity` is out of range.
    """
    limit = distance_at(model, min_similarity)
    shapes = read_columns(store, model.code_bits // 8)
    copied = copied_files(store.sources())
    later = {source.path for sources in copied for source in sources[1:]}
    superfluous = [number for path, number in shapes.sources.items() if path in later]
    rows = np.flatnonzero(~np.isin(shapes.source_of, superfluous))
    clusters: list[_ShapeCluster] = []
    with _vectors(store, model, shapes.shape_ids[rows]) as (found, vectors):
        rows, positions = rows[found], np.arange(len(found))
        counts = np.stack([shapes.vertex_count[rows], shapes.face_count[rows]], axis=1)
        classes = np.unique(counts, axis=0, return_inverse=True)[1].ravel().astype(np.int64)
        same_limit = min(limit, distance_at(model, SAME_SIMILARITY))
        for kind, max_distance in (("same", same_limit), ("similar", limit)):
            members = rows[positions]
            clustered = cluster_similar(
                model,
                shapes.codes[members],
                vectors,
                positions,
                max_distance,
                classes if kind == "same" else None,
                progress,
            )
            clusters += [
                _ShapeCluster(kind, shapes.shape_ids[members[group]].tolist(), clustered.distance[group])
                for group in clustered.groups()
            ]
            positions = positions[clustered.leaders()]
    groups = [group for sources in copied if (group := copy_group(shapes, sources)) is not None]
    return largest_saving_first([*groups, *_shape_groups(store, model, clusters)])


@dataclass(frozen=True, eq=False)
class _ShapeCluster:
    """Ids of shapes that form a group, the leader first, and their distances from it."""

    kind: str
    shape_ids: list[int]
    distances: FloatArray


@contextmanager
def _vectors(
    store: Store, model: ShapeModel, shape_ids: NDArray[np.int64]
) -> Iterator[tuple[NDArray[np.int64], FloatBags]]:
    """Positions of the shapes that have bags, and their vectors for comparison in a mapped temporary file."""
    width = model.comparable(np.zeros((1, model.bag_size), np.float32)).shape[1]
    found: list[NDArray[np.int64]] = [np.empty(0, np.int64)]
    with tempfile.TemporaryFile(prefix="shapegoogle-") as file:
        for start in range(0, len(shape_ids), PAGE):
            page = shape_ids[start : start + PAGE]
            ids, bags = store.bags(page.tolist(), model.bag_size)
            if ids:
                file.write(model.comparable(bags).astype(np.float32).tobytes())
                found.append(start + np.searchsorted(page, ids))
        file.flush()
        positions = np.concatenate(found)
        yield positions, _mapped(file, (len(positions), width))


def _mapped(file: IO[bytes], shape: tuple[int, int]) -> FloatBags:
    if 0 in shape:  # an empty file cannot be mapped
        return np.empty(shape, np.float32)
    return np.memmap(file, np.float32, mode="r", shape=shape)


def _shape_groups(
    store: Store, model: ShapeModel, clusters: Sequence[_ShapeCluster]
) -> Iterator[DuplicateGroup]:
    """Make the groups of clusters; names are read only now and only for these few shapes."""
    wanted = {shape_id for cluster in clusters for shape_id in cluster.shape_ids}
    records = {record.shape_id: record for record in store.shapes(list(wanted))}
    for cluster in clusters:
        similarities = model.similarity(cluster.distances).tolist()
        there = [
            (records[shape_id], similarity)
            for shape_id, similarity in zip(cluster.shape_ids, similarities, strict=True)
            if shape_id in records
        ]
        if len(there) < 2 or cluster.shape_ids[0] not in records:
            continue  # removed by another program meanwhile
        first = there[0][0]
        members = tuple(
            DuplicateMember(
                record.name,
                record.source,
                record.object_name,
                record.shape_id,
                similarity,
                _scale(first, record),
            )
            for record, similarity in there
        )
        lowest = min(similarity for _, similarity in there)
        yield DuplicateGroup(
            cluster.kind, members, lowest, saved_faces=sum(record.face_count for record, _ in there[1:])
        )


def _scale(first: ShapeRecord, other: ShapeRecord) -> float:
    return math.sqrt(other.area / first.area) if first.area > 0 and other.area > 0 else 1.0
