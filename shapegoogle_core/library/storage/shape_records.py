# SPDX-License-Identifier: MIT
"""Records of shapes from the rows of a database."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any

from shapegoogle_core.library.origin import SHAPE_TYPES, UNKNOWN, Origin
from shapegoogle_core.library.roots.paths import joined
from shapegoogle_core.library.storage.local_folders import LocalFolders
from shapegoogle_core.library.storage.records import ShapeRecord

__all__ = ["origins_from", "shape_records"]


def shape_records(
    rows: Iterable[tuple[Any, ...]],
    tags: Iterable[tuple[int, str]],
    origins: Mapping[int, Origin],
    folders: LocalFolders,
) -> list[ShapeRecord]:
    """Make records of shapes.

    Parameters
    ----------
    rows : iterable of tuple
        Id, name, path of the root or None, path of the source, name of the object, numbers of vertices and
        faces, area, three extents, number of placements.
    tags : iterable of (int, str)
        Ids of shapes, and a tag of each.
    origins : mapping of int to Origin
        By id; a shape without one is an object, or a file if it has no object name, in no catalog.
    folders : LocalFolders

    Returns
    -------
    records : list of ShapeRecord
    """
    tags_of: defaultdict[int, list[str]] = defaultdict(list)
    for shape_id, tag in tags:
        tags_of[shape_id].append(tag)
    sorted_tags = {shape_id: tuple(sorted(own)) for shape_id, own in tags_of.items()}
    # By position: a listing makes a million of them.
    return [
        ShapeRecord(
            i,
            name,
            path if root is None else joined(folders.of(root), path),
            object_name,
            vertices,
            faces,
            area,
            (x, y, z),
            sorted_tags.get(i, ()),
            placements,
            origins.get(i, UNKNOWN).completed(object_name),
        )
        for i, name, root, path, object_name, vertices, faces, area, x, y, z, placements in rows
    ]


def origins_from(rows: Iterable[tuple[int, str, str, int | None]]) -> dict[int, Origin]:
    """Make origins of shapes.

    Parameters
    ----------
    rows : iterable of tuple
        Id, type, catalog and frame.

    Returns
    -------
    origins : dict of int to Origin
        By id. A type that a newer version has introduced counts as unknown.
    """
    known = {str(shape_type): shape_type for shape_type in SHAPE_TYPES}
    return {
        shape_id: Origin(known.get(shape_type), catalog, frame)
        for shape_id, shape_type, catalog, frame in rows
    }
