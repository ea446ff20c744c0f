# SPDX-License-Identifier: MIT
"""Shapes, matches and duplicates as the service shows them: never with a path of its machine."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any

from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.roots.paths import containing_root, is_windows
from shapegoogle_core.library.storage.records import Root, ShapeRecord
from shapegoogle_core.service.contents import Place, Where
from shapegoogle_core.service.settings import ServiceError

__all__ = ["duplicate_record", "filter_from", "match_record", "place", "shape_record", "source_from"]


def place(source: str, roots: Sequence[Root]) -> dict[str, str]:
    """Return where a source lies, by the name of its root.

    Parameters
    ----------
    source : str
        Full path, or label.
    roots : sequence of Root
        Of the library.

    Returns
    -------
    place : dict
        ``root`` and ``path``. Of a path below no root only the last part is shown.
    """
    found = containing_root(source, [root.path for root in roots])
    if found is not None and found[1]:
        return {"root": roots[found[0]].name, "path": found[1]}
    if is_windows(source):
        return {"root": "", "path": PureWindowsPath(source).name}
    return {"root": "", "path": PurePosixPath(source).name if os.path.isabs(source) else source}  # noqa: PTH117


def shape_record(shape: ShapeRecord, roots: Sequence[Root]) -> dict[str, Any]:
    """Return a shape for `ShapeDetails`."""
    return {
        "shape_id": shape.shape_id,
        "name": shape.name,
        "object_name": shape.object_name,
        "source": place(shape.source, roots),
        "vertices": shape.vertex_count,
        "faces": shape.face_count,
        "area": shape.area,
        "extents": list(shape.extents),
        "tags": list(shape.tags),
        "placements": shape.placement_count,
        "shape_type": shape.origin.completed(shape.object_name).shape_type,
        "catalog": shape.origin.catalog,
        "frame": shape.origin.frame,
    }


def match_record(match: Match, tags: Sequence[str], roots: Sequence[Root]) -> dict[str, Any]:
    """Return a match for `MatchRecord`: as the command line shows it, and what a page needs besides."""
    return {
        "placement": None,
        "versions": 0,
        "catalog": "",
        "frame": None,
        **match.to_json(),
        "source": place(match.source, roots),
        "shape_id": match.shape_id,
        "version_ids": list(match.version_ids),
        "vertices": match.vertex_count,
        "faces": match.face_count,
        "area": match.area,
        "tags": list(tags),
    }


def duplicate_record(group: DuplicateGroup, roots: Sequence[Root]) -> dict[str, Any]:
    """Return a group of duplicates for `DuplicateRecord`."""
    members = [{**member.to_json(), "source": place(member.source, roots)} for member in group.members]
    return {**group.to_json(), "title": group.title, "members": members}


def filter_from(where: Where | None, library: Library) -> Filter | None:
    """Make the filter of a request.

    Parameters
    ----------
    where : Where or None
    library : Library

    Returns
    -------
    where : Filter or None
        None without conditions.

    Raises
    ------
    ServiceError
        422 if the conditions cannot be met by any shape, or the folder lies below no root.
    """
    if where is None:
        return None
    conditions = where.model_dump(exclude_none=True)
    roots = library.roots(counted=False)
    if where.folder is not None:
        conditions["folder"] = _folder(where.folder, roots)
    for field, places in (("sources", where.sources), ("not_sources", where.not_sources)):
        if places is not None:
            conditions[field] = tuple(source_from(given, roots) for given in places)
    try:
        made = Filter(**conditions)
    except ValueError as error:
        raise ServiceError(422, str(error)) from error
    return None if made == Filter() else made


def source_from(given: Place, roots: Sequence[Root]) -> str:
    """Return a source that is named by its root; a path of this machine is no name for it.

    Parameters
    ----------
    given : Place
    roots : sequence of Root
        Of the library.

    Returns
    -------
    source : str

    Raises
    ------
    ServiceError
        422 if there is no such root, or it is a path of this machine.
    """
    if not given.root:
        if os.path.isabs(given.path) or is_windows(given.path):  # noqa: PTH117
            raise ServiceError(422, "a source is the name of a root and a path below it, or a label")
        return given.path
    return _folder(f"{given.root}/{given.path}", roots)


def _folder(text: str, roots: Sequence[Root]) -> str:
    """Return the path of a folder that is named by its root."""
    name, _, below = text.replace("\\", "/").strip("/").partition("/")
    for root in roots:
        if root.name == name and ".." not in below.split("/"):
            return f"{root.path}/{below}" if below else root.path
    names = ", ".join(repr(root.name) for root in roots) or "none"
    raise ServiceError(
        422, f"there is no folder {text!r}; begin with the name of a root of this library ({names})"
    )
