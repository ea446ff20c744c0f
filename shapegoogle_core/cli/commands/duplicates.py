# SPDX-License-Identifier: MIT
"""List copied files and shapes that are the same or hard to tell apart.

copies     files that are equal byte for byte
identical  the same geometry in the same place; the other kinds are relative to the first of the group:
moved, scaled, mirrored   the same geometry elsewhere, at another size, or reflected
re-meshed  the same surface with other vertices
version    nearly the same surface: subdivided, smoothed, or with fewer faces
re-posed   bent; "part of" and "contains": the first is a part of the others, or they are parts of it
similar    at least --min-similarity to the first of the group, and none of these
not compared   the same, but the surfaces were not compared: beyond --evidence, or none are stored

Every shape is compared with the first of its group, never through a chain of others. The saving counts all
members but the first: their faces, and for copies the bytes of the files. Nothing is changed or deleted.
With --json, one line for each group, the largest saving first:
  {"kind", "similarity", "saving": {"faces", "bytes"},
   "members": [{"name", "source", "object_name", "shape_id", "similarity", "scale", "placements"}, …]}

for example:
  shapegoogle duplicates --library shapes.sglib
  shapegoogle duplicates --library shapes.sglib --json | jq -r 'select(.kind == "copies") | .members[].source'
"""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

from shapegoogle_core.cli.arguments import (
    SEARCHED,
    add_flag,
    add_library,
    add_roots,
    add_value,
    map_roots,
    number_from,
    positive_share,
)
from shapegoogle_core.cli.command import DONE, Command
from shapegoogle_core.cli.text import counted, put, table
from shapegoogle_core.library.duplicates.settings import EXPLAINED_MEMBERS, MIN_SIMILARITY

if TYPE_CHECKING:
    from shapegoogle_core.library.duplicates.groups import DuplicateGroup, DuplicateMember

__all__ = ["COMMAND"]

# One copy would be enough. Most users see a mirror image as another shape.
_EXACT = {"copies", "identical", "moved", "scaled"}


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_library(parser, SEARCHED)
    add_roots(parser)
    similarity = "least similarity to the first of a group, above 0 and at most 1 (%(default)s)"
    add_value(parser, "--min-similarity", "S", similarity, positive_share, MIN_SIMILARITY)
    explained = (
        "number of shapes, other than exact copies, whose surfaces are compared to find their kind "
        "(%(default)s)"
    )
    add_value(parser, "--evidence", "N", explained, number_from(0), EXPLAINED_MEMBERS)
    add_flag(parser, "--json", "print one JSON object for each group")


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.client import open_library
    from shapegoogle_core.processes.progress import progress_bar

    with open_library(options.library) as library:
        map_roots(library, options)
        groups = library.duplicates(
            options.min_similarity,
            lambda positions: progress_bar(positions, "comparing", len(positions)),
            explained=options.evidence,
        )
        shapes = len(library)
    if options.json:
        for group in groups:
            put(json.dumps(group.to_json()))
        return DONE
    for group in groups:
        put(f"{_group_table(group)}\n")
    saved_faces = sum(group.saved_faces for group in groups if group.kind in _EXACT)
    saved_bytes = sum(group.saved_bytes for group in groups)
    put(
        f"{counted(len(groups), 'group')} among {counted(shapes, 'shape')}; exact copies repeat "
        f"{saved_faces:,} faces, copied files {saved_bytes:,} bytes"
    )
    return DONE


def _group_table(group: DuplicateGroup) -> str:
    saving = f"{group.saved_faces:,} faces"
    if group.saved_bytes:
        saving += f", {group.saved_bytes:,} bytes"
    noun = "file" if group.kind == "copies" else "shape"
    rows = [
        (
            f"  {member.similarity:.3f}",
            f"×{member.scale:.4g}",
            _name(member),
            member.source,
        )
        for member in group.members
    ]
    title = f"{group.title}: {counted(len(group.members), noun)}; {saving} besides the first"
    return "\n".join([title, *table(rows, "<<<<")])


def _name(member: DuplicateMember) -> str:
    name = member.object_name or member.name
    return name if member.placements == 1 else f"{name} ×{member.placements:,}"


COMMAND = Command("duplicates", str(__doc__), _add_options, _run)
