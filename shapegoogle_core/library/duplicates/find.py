# SPDX-License-Identifier: MIT
"""Search for duplicates in a library: copied files, the same shape again, and similar shapes."""

from __future__ import annotations

import math
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.duplicates.groups import DuplicateGroup, DuplicateMember, largest_saving_first
from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
from shapegoogle_core.library.duplicates.same_mesh import group_copies
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.duplicates.similar import cluster_similar, distance_at
from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.storage.records import ShapeRecord, SourceRecord
from shapegoogle_core.library.storage.signatures import unpack_measures
from shapegoogle_core.library.storage.store import Store, all_codes
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.registration import MeshMeasures

__all__ = ["find_duplicates"]

# Bags and records read at once.
PAGE = 2_000


def find_duplicates(
    store: Store, model: ShapeModel, min_similarity: float = MIN_SIMILARITY, progress: Wrapper = iter
) -> list[DuplicateGroup]:
    """Find the groups of duplicates in a library.

    Copied files come first: of each set of equal files only the first takes part in the next steps. Then
    copies of a mesh are grouped around the oldest of them, by their measures, and the remaining shapes, one
    for each group, by similarity; see `leader_clustering` for the method and for pairs that its keys may
    miss. No shape is in two groups of one kind. The vectors that are compared lie in a temporary file;
    ``docs/reference/library.md`` gives its size.

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
    shapes = _read_columns(store, model.code_bits // 8)
    copied = _copied_files(store.sources())
    later = {source.path for sources in copied for source in sources[1:]}
    superfluous = [number for path, number in shapes.sources.items() if path in later]
    rows = np.flatnonzero(~np.isin(shapes.source_of, superfluous))
    clusters, repeated = _copied_meshes(store, model, shapes.shape_ids[rows])
    rows = rows[~np.isin(shapes.shape_ids[rows], repeated)]
    with _vectors(store, model, shapes.shape_ids[rows]) as (found, vectors):
        rows = rows[found]
        clustered = cluster_similar(
            model, shapes.codes[rows], vectors, np.arange(len(rows)), limit, progress=progress
        )
        clusters += [
            _ShapeCluster("similar", shapes.shape_ids[rows[group]].tolist(), clustered.distance[group])
            for group in clustered.groups()
        ]
    groups = [group for sources in copied if (group := _copy_group(shapes, sources)) is not None]
    return largest_saving_first([*groups, *_shape_groups(store, model, clusters)])


@dataclass(frozen=True, eq=False)
class _ShapeCluster:
    """Ids of shapes that form a group, the leader first, and their distances from it."""

    kind: str
    shape_ids: list[int]
    distances: FloatArray


def _copied_meshes(
    store: Store, model: ShapeModel, shape_ids: NDArray[np.int64]
) -> tuple[list[_ShapeCluster], list[int]]:
    """Group copies of meshes, and list all of them but the first of each group."""
    measures: dict[int, MeshMeasures] = {}
    for start in range(0, len(shape_ids), PAGE):
        measures |= unpack_measures(store, shape_ids[start : start + PAGE].tolist())
    clusters = []
    for group in group_copies(measures):
        found, bags = store.bags(group, model.bag_size)
        if len(found) == len(group):  # otherwise another program is removing them
            away = np.round(model.distances(bags[0], bags), DISTANCE_DECIMALS)
            clusters.append(_ShapeCluster("same", group, away))
    return clusters, [shape_id for cluster in clusters for shape_id in cluster.shape_ids[1:]]


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
        shape = len(positions), width
        if 0 in shape:  # an empty file cannot be mapped
            yield positions, np.empty(shape, np.float32)
        else:
            yield positions, np.memmap(file, np.float32, mode="r", shape=shape)


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
                record.placement_count,
            )
            for record, similarity in there
        )
        lowest = min(similarity for _, similarity in there)
        yield DuplicateGroup(
            cluster.kind, members, lowest, saved_faces=sum(record.face_count for record, _ in there[1:])
        )


def _scale(first: ShapeRecord, other: ShapeRecord) -> float:
    return math.sqrt(other.area / first.area) if first.area > 0 and other.area > 0 else 1.0


def _copied_files(sources: Iterable[SourceRecord]) -> list[list[SourceRecord]]:
    """Collect the files that have shapes and the same content as another file.

    Parameters
    ----------
    sources : iterable of SourceRecord
        In the order of their paths.

    Returns
    -------
    copies : list of list of SourceRecord
        Sets of two or more equal files, in the order of paths.
    """
    by_content: defaultdict[str, list[SourceRecord]] = defaultdict(list)
    for source in sources:
        if source.sha256 is not None and source.shape_count:
            # The options of the reader behind the hash are not part of the content.
            by_content[source.sha256.partition("+")[0]].append(source)
    return [copies for copies in by_content.values() if len(copies) > 1]


def _copy_group(shapes: _ShapeColumns, sources: Sequence[SourceRecord]) -> DuplicateGroup | None:
    """Make the group of a set of equal files.

    Parameters
    ----------
    shapes : _ShapeColumns
        Of the whole library.
    sources : sequence of SourceRecord
        Equal files.

    Returns
    -------
    group : DuplicateGroup or None
        None if fewer than two of the files still have shapes.
    """
    members, faces, saved_bytes = [], [], 0
    for source in sources:
        rows = np.flatnonzero(shapes.source_of == shapes.sources.get(source.path, -1))
        if len(rows):
            name, shape_id = Path(source.path).name, int(shapes.shape_ids[rows[0]])
            members.append(DuplicateMember(name, source.path, "", shape_id, 1.0, 1.0))
            faces.append(int(shapes.counts[rows, 1].sum()))
            saved_bytes += (source.size or 0) if len(members) > 1 else 0
    if len(members) < 2:
        return None
    return DuplicateGroup("copies", tuple(members), 1.0, sum(faces[1:]), saved_bytes)


@dataclass(frozen=True, eq=False)
class _ShapeColumns:
    """All shapes of a library, one row for each, in the order of their ids.

    Attributes
    ----------
    shape_ids : (n,) array of int64
    codes : (n, s/8) array of uint8
    counts : (n, 2) array of int64
        Vertices and faces.
    source_of : (n,) array of int64
        Number of each shape's source in `sources`.
    sources : dict of str to int
        Numbers of the paths.
    """

    shape_ids: NDArray[np.int64]
    codes: NDArray[np.uint8]
    counts: NDArray[np.int64]
    source_of: NDArray[np.int64]
    sources: dict[str, int]


def _read_columns(store: Store, code_bytes: int) -> _ShapeColumns:
    """Read codes, counts and sources of all shapes.

    Parameters
    ----------
    store : Store
    code_bytes : int
        Length of each code.

    Returns
    -------
    columns : _ShapeColumns
        Without shapes that another program adds or removes meanwhile.
    """
    shape_ids, codes = all_codes(store, "codes", code_bytes)
    numbers = np.zeros((len(shape_ids), 3), np.int64)  # vertices, faces, source
    known = np.zeros(len(shape_ids), bool)
    sources: dict[str, int] = {}
    last_id = 0
    while page := store.shapes_after(last_id, PAGE):
        last_id = page[-1].shape_id
        rows = np.searchsorted(shape_ids, [record.shape_id for record in page])
        for row, record in zip(rows.tolist(), page, strict=True):
            if row < len(shape_ids) and shape_ids[row] == record.shape_id:
                source = sources.setdefault(record.source, len(sources))
                numbers[row] = record.vertex_count, record.face_count, source
                known[row] = True
    numbers = numbers[known]
    return _ShapeColumns(shape_ids[known], codes[known], numbers[:, :2], numbers[:, 2], sources)
