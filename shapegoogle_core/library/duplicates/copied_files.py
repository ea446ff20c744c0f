# SPDX-License-Identifier: MIT
"""Files of a library that are equal byte for byte."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

from shapegoogle_core.library.duplicates.groups import DuplicateGroup, DuplicateMember
from shapegoogle_core.library.duplicates.shape_columns import ShapeColumns
from shapegoogle_core.library.storage.records import SourceRecord

__all__ = ["copied_files", "copy_group"]


def copied_files(sources: Iterable[SourceRecord]) -> list[list[SourceRecord]]:
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


def copy_group(shapes: ShapeColumns, sources: Sequence[SourceRecord]) -> DuplicateGroup | None:
    """Make the group of a set of equal files.

    Parameters
    ----------
    shapes : ShapeColumns
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
        rows = shapes.rows_of(source.path)
        if len(rows):
            name, shape_id = Path(source.path).name, int(shapes.shape_ids[rows[0]])
            members.append(DuplicateMember(name, source.path, "", shape_id, 1.0, 1.0))
            faces.append(int(shapes.face_count[rows].sum()))
            saved_bytes += (source.size or 0) if len(members) > 1 else 0
    if len(members) < 2:
        return None
    return DuplicateGroup("copies", tuple(members), 1.0, sum(faces[1:]), saved_bytes)
