# SPDX-License-Identifier: MIT
"""Duplicates in a library: copied files, the same shape again, and shapes hard to tell apart."""

from __future__ import annotations

import math
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.duplicates.leader_clustering import (
    Distances,
    Stars,
    Wrapper,
    choose_banding,
    group_stars,
)
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.storage.records import ShapeRecord, SourceRecord
from shapegoogle_core.library.storage.store import Store, all_codes
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.describe import FloatBags

__all__ = [
    "MIN_SIMILARITY",
    "SAME_SIMILARITY",
    "DuplicateGroup",
    "DuplicateMember",
    "differing_bits",
    "distance_at",
    "find_duplicates",
    "largest_saving_first",
    "member_positions",
    "vector_distances",
]

SAME_SIMILARITY = 0.99999
"""From which similarity on two bags are the same one, computed again on moved or reordered vertices.

With the shipped model moved, scaled and reordered copies of a mesh come to 0.9999996 or more, two bumpy
spheres of the same triangulation to 0.9995 at most.
"""

# Share of bits taken to differ at the limit, for a metric without an angle to derive it from.
DIFFERING_BITS = 0.15
PAGE = 2_000


@dataclass(frozen=True)
class DuplicateMember:
    """A shape, or a file, of a group.

    Attributes
    ----------
    name, source, object_name : str
        As in `Match`. In a group of copies the file stands for all of its shapes; `name` is the file's.
    shape_id : int
        In a group of copies that of the file's first shape.
    similarity : float
        To the first member; 1 for itself.
    scale : float
        Linear size of it relative to the first member, from their areas; 1 where an area is 0.
    """

    name: str
    source: str
    object_name: str
    shape_id: int
    similarity: float
    scale: float


@dataclass(frozen=True)
class DuplicateGroup:
    """Shapes of which one might do.

    Attributes
    ----------
    kind : str
        "copies": files that are equal byte for byte. "same": the same bag to rounding, vertex and face count;
        position, size and mirroring are not looked at. "similar": at least as similar to the first member as
        was asked for. Where geometry was compared it is, in place of the latter two, what the members are,
        seen from the first: one of `evidence.KINDS`.
    members : tuple of DuplicateMember
        The first one represents the group: the others are compared with it, and come by falling similarity.
    similarity : float
        The lowest of the members'.
    saved_faces : int
        Faces of all members but the first.
    saved_bytes : int
        Size of all files but the first, in a group of copies; else 0, as nothing is known of parts of files.
    """

    kind: str
    members: tuple[DuplicateMember, ...]
    similarity: float
    saved_faces: int
    saved_bytes: int = 0

    def to_json(self) -> dict[str, object]:
        """Put the group into the form that ``shapegoogle duplicates --json`` prints.

        Returns
        -------
        record : dict
            ``kind``, ``similarity``, ``saving`` (``faces``, ``bytes``) and ``members``, each with ``name``,
            ``source``, ``object_name``, ``shape_id``, ``similarity`` and ``scale``.
        """
        return {
            "kind": self.kind,
            "similarity": round(self.similarity, 6),
            "saving": {"faces": self.saved_faces, "bytes": self.saved_bytes},
            "members": [
                {
                    "name": member.name,
                    "source": member.source,
                    "object_name": member.object_name,
                    "shape_id": member.shape_id,
                    "similarity": round(member.similarity, 6),
                    "scale": round(member.scale, 6),
                }
                for member in self.members
            ],
        }


def distance_at(model: ShapeModel, similarity: float) -> float:
    """Distance at which a model gives a similarity: the inverse of `ShapeModel.similarity`.

    Parameters
    ----------
    model : ShapeModel
    similarity : float
        0 < similarity ≤ 1.

    Returns
    -------
    distance : float
        ≥ 0.

    Raises
    ------
    ValueError
        If the similarity is out of range.
    """
    if not 0 < similarity <= 1:
        raise ValueError(f"a similarity to group by must be above 0 and at most 1, not {similarity}")
    return float(model.similarity_half * (1 / similarity - 1) ** (1 / model.similarity_slope))


def find_duplicates(
    store: Store, model: ShapeModel, min_similarity: float = MIN_SIMILARITY, progress: Wrapper = iter
) -> list[DuplicateGroup]:
    """Find the groups of duplicates in a store.

    Copied files come first: of each set of equal files only the first takes part in what follows. Then the
    same shapes are grouped around the oldest of them, and those left, one for each group, by similarity (see
    `stars` on how, and on what keys of codes can miss). No shape is in two groups of a kind. Bags are read
    page by page; the vectors that are compared lie in a temporary file, 160 MB for 100,000 shapes of the
    default model.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        The one that described the shapes.
    min_similarity : float
        0 < min_similarity ≤ 1.
    progress : callable, optional
        Wraps the loop over the shapes, as tqdm does.

    Returns
    -------
    groups : list of DuplicateGroup
        The largest saving first: faces, then bytes.
    """
    limit = distance_at(model, min_similarity)
    table = _Table.read(store, model)
    copied = _copied_files(store.sources())
    later = {source.path for sources in copied for source in sources[1:]}
    superfluous = [number for path, number in table.sources.items() if path in later]
    rows = np.flatnonzero(~np.isin(table.source_of, superfluous))
    chosen: list[_Star] = []
    with _vectors(store, model, table.shape_ids[rows]) as (found, vectors):
        rows, positions = rows[found], np.arange(len(found))
        counts = np.stack([table.vertex_count[rows], table.face_count[rows]], axis=1)
        classes = np.unique(counts, axis=0, return_inverse=True)[1].ravel().astype(np.int64)
        same_limit = min(limit, distance_at(model, SAME_SIMILARITY))
        for kind, max_distance in (("same", same_limit), ("similar", limit)):
            stars = group_stars(
                table.codes[rows[positions]],
                vector_distances(vectors, positions, model.settings.metric),
                max_distance,
                choose_banding(len(positions), differing_bits(model, max_distance), model.code_bits),
                classes if kind == "same" else None,
                progress,
            )
            members = rows[positions]
            chosen += [
                _Star(kind, members[group], stars.distance[group]) for group in member_positions(stars)
            ]
            positions = positions[stars.leader == np.arange(len(positions))]
    groups = [group for sources in copied if (group := _copy_group(table, sources)) is not None]
    groups += _shape_groups(store, model, table, chosen)
    return largest_saving_first(groups)


def largest_saving_first(groups: Sequence[DuplicateGroup]) -> list[DuplicateGroup]:
    """Sort groups by the faces that all members but the first have, then by their bytes."""
    return sorted(
        groups,
        key=lambda group: (-group.saved_faces, -group.saved_bytes, group.kind, group.members[0].shape_id),
    )


@dataclass(frozen=True, eq=False)
class _Star:
    """Rows of the table that form a group, the leader first, and their distances to it."""

    kind: str
    rows: NDArray[np.int64]
    distances: FloatArray


@dataclass(frozen=True, eq=False)
class _Table:
    """What is known of all shapes, one row for each, in the order of their ids."""

    shape_ids: NDArray[np.int64]
    codes: NDArray[np.uint8]
    vertex_count: NDArray[np.int64]
    face_count: NDArray[np.int64]
    area: FloatArray
    source_of: NDArray[np.int64]
    sources: dict[str, int]

    def rows_of(self, source: str) -> NDArray[np.int64]:
        number = self.sources.get(source, -1)
        return np.flatnonzero(self.source_of == number)

    @classmethod
    def read(cls, store: Store, model: ShapeModel) -> _Table:
        shape_ids, codes = all_codes(store, "codes", model.code_bits // 8)
        numbers = np.zeros((len(shape_ids), 3), np.int64)  # vertices, faces, source
        area = np.zeros(len(shape_ids))
        known = np.zeros(len(shape_ids), bool)
        sources: dict[str, int] = {}
        last_id = 0
        while page := store.shapes_after(last_id, PAGE):
            last_id = page[-1].shape_id
            rows = np.searchsorted(shape_ids, [record.shape_id for record in page])
            for row, record in zip(rows.tolist(), page, strict=True):
                # Another program may add and remove shapes meanwhile.
                if row < len(shape_ids) and shape_ids[row] == record.shape_id:
                    source = sources.setdefault(record.source, len(sources))
                    numbers[row] = record.vertex_count, record.face_count, source
                    area[row], known[row] = record.area, True
        vertices, faces, source_of = numbers[known].T
        return cls(shape_ids[known], codes[known], vertices, faces, area[known], source_of, sources)


def _copied_files(sources: Sequence[SourceRecord]) -> list[list[SourceRecord]]:
    """Collect files with the same content that gave shapes: sets of two or more, in the order of paths."""
    by_content: defaultdict[str, list[SourceRecord]] = defaultdict(list)
    for source in sources:
        if source.sha256 is not None and source.shape_count:
            # The reader's options behind the hash are no part of the content.
            by_content[source.sha256.partition("+")[0]].append(source)
    return [copies for copies in by_content.values() if len(copies) > 1]


@contextmanager
def _vectors(
    store: Store, model: ShapeModel, shape_ids: NDArray[np.int64]
) -> Iterator[tuple[NDArray[np.int64], FloatBags]]:
    """Which of these shapes have bags, and what the model compares of them, mapped from a temporary file."""
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


def vector_distances(vectors: FloatBags, positions: NDArray[np.int64], metric: str) -> Distances:
    """Measure between rows of an array, for `group_stars`.

    Parameters
    ----------
    vectors : (n, p) array of float32
        From `ShapeModel.comparable`; may be mapped from a file.
    positions : (m,) array of int64
        The rows to compare, by whose number in here they are called.
    metric : {"cosine", "l1"}

    Returns
    -------
    distances : callable
        As `group_stars` takes it; rounded as the search rounds.
    """

    def measure(position: int, others: NDArray[np.int64]) -> FloatArray:
        one = vectors[positions[position]][None]
        return np.round(row_distances(metric, one, vectors[positions[others]]), DISTANCE_DECIMALS)

    return measure


def differing_bits(model: ShapeModel, distance: float) -> float:
    """Share of bits in which the codes of two shapes at a distance should differ.

    Parameters
    ----------
    model : ShapeModel
    distance : float

    Returns
    -------
    share : float
        θ / π, from 0 to 1; `DIFFERING_BITS` for a metric without angles.
    """
    if model.settings.metric == "cosine":
        return math.acos(max(-1.0, 1 - distance)) / math.pi
    return DIFFERING_BITS


def member_positions(stars: Stars) -> list[NDArray[np.int64]]:
    """List the stars that have members.

    Parameters
    ----------
    stars : Stars

    Returns
    -------
    groups : list of (g,) arrays of int64
        Positions, the leader first, then by distance.
    """
    order = np.lexsort((np.arange(len(stars.leader)), stars.distance, stars.leader))
    # A leader has distance 0 and the lowest position, so it is the first of its star.
    starts = np.flatnonzero(np.diff(stars.leader[order], prepend=-1))
    return [group for group in np.split(order, starts[1:]) if len(group) > 1]


def _copy_group(table: _Table, sources: Sequence[SourceRecord]) -> DuplicateGroup | None:
    """Group of a set of equal files; None where shapes of them went while the table was read."""
    members, faces, saved_bytes = [], [], 0
    for source in sources:
        rows = table.rows_of(source.path)
        if len(rows):
            name, shape_id = Path(source.path).name, int(table.shape_ids[rows[0]])
            members.append(DuplicateMember(name, source.path, "", shape_id, 1.0, 1.0))
            faces.append(int(table.face_count[rows].sum()))
            saved_bytes += (source.size or 0) if len(members) > 1 else 0
    if len(members) < 2:
        return None
    return DuplicateGroup("copies", tuple(members), 1.0, sum(faces[1:]), saved_bytes)


def _shape_groups(
    store: Store, model: ShapeModel, table: _Table, stars: Sequence[_Star]
) -> list[DuplicateGroup]:
    """Give groups of shapes their names, which are read only now and only for these few."""
    wanted = {int(shape_id) for star in stars for shape_id in table.shape_ids[star.rows]}
    records = {record.shape_id: record for record in store.shapes(list(wanted))}
    groups = []
    for star in stars:
        ids = table.shape_ids[star.rows].tolist()
        similarities = model.similarity(star.distances).tolist()
        there = [(records[i], s) for i, s in zip(ids, similarities, strict=True) if i in records]
        if len(there) < 2 or ids[0] not in records:
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
        faces = sum(record.face_count for record, _ in there[1:])
        groups.append(DuplicateGroup(star.kind, members, min(s for _, s in there), faces))
    return groups


def _scale(first: ShapeRecord, other: ShapeRecord) -> float:
    return math.sqrt(other.area / first.area) if first.area > 0 and other.area > 0 else 1.0
