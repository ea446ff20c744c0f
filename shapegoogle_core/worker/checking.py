# SPDX-License-Identifier: MIT
"""Requests of the check of new objects: whether shapes are in the library already, or nearly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.errors import MeshError
from shapegoogle_core.library.decisions.decision import Decision, ShapeKey
from shapegoogle_core.library.decisions.fingerprint import fingerprint
from shapegoogle_core.library.evidence import EvidenceKind
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.storage.address import Place
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeSignature
from shapegoogle_core.worker.requests import open_library

__all__ = ["Near", "check_meshes", "names_of"]

# The same shape, whatever its similarity.
SAME: frozenset[EvidenceKind] = frozenset(
    {"identical", "moved", "scaled", "mirrored", "re-meshed", "version", "re-posed"}
)
# Other things, whatever their similarity.
OTHER: frozenset[EvidenceKind] = frozenset({"part of", "contains", "same kind", "nothing in common"})
# Matches that are looked at: the best one may be one that is kept beside the object.
LOOKED_AT = 5
# Shapes of one file whose names are listed.
MOST_SHAPES = 100_000


@dataclass(frozen=True, eq=False)
class Near:
    """A shape that is in a library already, or nearly.

    Attributes
    ----------
    match : Match
        The library's, with its evidence.
    signature : ShapeSignature
        Of the shape that was checked.
    """

    match: Match
    signature: ShapeSignature


def check_meshes(
    path: LibraryAddress | Place, meshes: Sequence[Mesh], source: str, least: float
) -> list[Near | str | None]:
    """Look for shapes in a library that are nearly duplicates of others.

    Parameters
    ----------
    path : LibraryAddress, Path or str
        The library.
    meshes : sequence of Mesh
        Each named after its object.
    source : str
        The file that they are in, whose own shapes in the library do not count.
    least : float
        Least similarity of a shape that is neither a copy nor a version nor another pose.

    Returns
    -------
    found : list of Near, None or str
        For each mesh the best that is not kept beside it; None if there is none, a sentence for a mesh that
        cannot be described.

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    """
    library = open_library(path)
    kept = [decision for decision in library.decisions() if decision.kind == "keep both"]
    others = Filter(not_sources=(source,))
    found: list[Near | str | None] = []
    for mesh in meshes:
        try:
            signature = library.model.describe(mesh, keep_surface=True)
        except MeshError as error:
            found.append(str(error))
            continue
        matches = library.query(signature, top=LOOKED_AT, explain=LOOKED_AT, where=others, rank="shape")
        near = [match for match in matches if _is_near(match, least)]
        if kept:
            near = [
                match
                for match in near
                if not _is_kept(
                    kept,
                    ShapeKey("", source, mesh.name, mesh.name, fingerprint=fingerprint(signature)),
                    ShapeKey(
                        "",
                        match.source,
                        match.object_name,
                        match.name,
                        fingerprint=fingerprint(library.signature(match.shape_id)),
                    ),
                )
            ]
        found.append(Near(near[0], signature) if near else None)
    return found


def _is_near(match: Match, least: float) -> bool:
    kind = None if match.evidence is None else match.evidence.kind
    return kind in SAME or (kind not in OTHER and match.similarity >= least)


def _is_kept(kept: Sequence[Decision], own: ShapeKey, other: ShapeKey) -> bool:
    """Whether it was decided that two shapes are both kept."""
    return any(
        decision.other is not None
        and (
            (_is_one(decision.shape, own) and _is_one(decision.other, other))
            or (_is_one(decision.shape, other) and _is_one(decision.other, own))
        )
        for decision in kept
    )


def _is_one(key: ShapeKey, shape: ShapeKey) -> bool:
    """Whether a key names a shape: by its mesh, or by its place where the mesh has changed."""
    if key.fingerprint and key.fingerprint == shape.fingerprint:
        return True
    names = (key.object_name, key.name) == (shape.object_name, shape.name)
    # One of the two may be known below its root only.
    path = "/" + shape.path.replace("\\", "/")
    return names and bool(key.path) and path.endswith("/" + key.path.lstrip("/"))


def names_of(path: LibraryAddress | Place, source: str) -> frozenset[str]:
    """List the names of all objects of a file that are in a library.

    Parameters
    ----------
    path : LibraryAddress, Path or str
        The library.
    source : str
        Path or label of the file.

    Returns
    -------
    names : frozenset of str

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    """
    library = open_library(path)
    names: set[str] = set()
    for shape in library.find(Filter(sources=(source,)), limit=MOST_SHAPES):
        names.add(shape.object_name)
        if shape.placement_count > 1:
            names.update(placement.object_name for placement in library.placements(shape.shape_id))
    return frozenset(names)
