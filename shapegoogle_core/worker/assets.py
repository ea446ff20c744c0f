# SPDX-License-Identifier: MIT
"""Requests about assets: the shape of a library that one is, and suggestions of tags and catalogs."""

from __future__ import annotations

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.storage.address import Place
from shapegoogle_core.library.suggestions import Suggestion
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.worker.requests import StoredExample, open_library

__all__ = ["shape_of", "suggest"]

# Shapes of one file among which an asset is searched.
MOST_SHAPES = 100_000


def shape_of(
    path: LibraryAddress | Place, source: str, name: str, *, is_collection: bool = False
) -> StoredExample | None:
    """Find the shape of a library that an object or a collection of a file is.

    Parameters
    ----------
    path : LibraryAddress, Path or str
        The library.
    source : str
        Path of the file.
    name : str
        Name of the object or the collection in it.
    is_collection : bool, optional

    Returns
    -------
    shape : (int, str) or None
        Its id and name; None if the library has no such shape.

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    """
    library = open_library(path)
    others: list[StoredExample] = []
    for shape in library.find(Filter(sources=(source,)), limit=MOST_SHAPES):
        if (shape.origin.shape_type == "collection") != is_collection:
            continue
        if shape.object_name == name:
            return shape.shape_id, shape.name
        if shape.placement_count > 1 and any(
            placement.object_name == name for placement in library.placements(shape.shape_id)
        ):
            others.append((shape.shape_id, shape.name))
    return others[0] if others else None


def suggest(path: LibraryAddress | Place, mesh: Mesh, source: str, name: str) -> list[Suggestion]:
    """Suggest tags and catalogs for an object; see `Library.suggest`.

    Parameters
    ----------
    path : LibraryAddress, Path or str
        The library.
    mesh : Mesh
        Used if the object is not in the library.
    source, name : str
        Its file and its name; it is no relative of its own.

    Returns
    -------
    suggestions : list of Suggestion
        The most confident first.

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    MeshError
        If the mesh cannot be described.
    """
    own = shape_of(path, source, name)
    found = open_library(path).suggest(mesh if own is None else own[0])
    return [suggestion for suggestion in found if suggestion.kind in ("tag", "catalog")]
