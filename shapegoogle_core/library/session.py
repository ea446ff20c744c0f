# SPDX-License-Identifier: MIT
"""What a user interface has another process do: functions whose arguments and results can be sent.

They keep libraries open from one question to the next, each as long as the process lives, so that only the
first question reads the codes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.match import Match
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeSignature

__all__ = ["Answer", "describe", "query", "warm_up"]

# Open libraries by path, each with what tells its file from another one put in its place.
_open: dict[Path, tuple[tuple[int, int], Library]] = {}


@dataclass(frozen=True)
class Answer:
    """The answer to a query.

    Attributes
    ----------
    matches : list of Match
        Best first.
    thumbnails : dict of int to bytes
        Pictures as PNG by shape id, of those matches that have one.
    area : float
        Of the query, in squared units.
    """

    matches: list[Match]
    thumbnails: dict[int, bytes]
    area: float


def query(path: Path, mesh: Mesh, top: int) -> Answer:
    """Find the shapes of a library that are most like a mesh.

    Parameters
    ----------
    path : Path
        The library.
    mesh : Mesh
    top : int
        How many matches.

    Returns
    -------
    answer : Answer

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    MeshError
        If the mesh cannot be described.
    """
    library = _library(path)
    signature = library.model.describe(mesh)
    matches = library.query_signature(signature, top)
    pictures = ((match.shape_id, library.thumbnail(match.shape_id)) for match in matches)
    return Answer(matches, {shape_id: png for shape_id, png in pictures if png is not None}, signature.area)


def describe(path: Path, meshes: Sequence[Mesh]) -> list[ShapeSignature | str]:
    """Describe meshes with the model of a library.

    Parameters
    ----------
    path : Path
        The library.
    meshes : sequence of Mesh

    Returns
    -------
    signatures : list of ShapeSignature or str
        One for each mesh; where one cannot be described, the sentence that says why.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    """
    from shapegoogle_core.errors import MeshError

    model = _library(path).model
    signatures: list[ShapeSignature | str] = []
    for mesh in meshes:
        try:
            signatures.append(model.describe(mesh))
        except MeshError as error:
            signatures.append(str(error))
    return signatures


def warm_up() -> None:
    """Do nothing; what importing this module and the first eigenproblem load is loaded then."""
    import scipy.sparse.linalg  # noqa: F401

    import shapegoogle_core.rendering  # noqa: F401


def _library(path: Path) -> Library:
    status = path.stat() if path.exists() else None
    identity = (0, 0) if status is None else (status.st_dev, status.st_ino)
    known = _open.get(path)
    if known is not None:
        if known[0] == identity:
            return known[1]
        del _open[path]
        known[1].close()
    library = Library.open(path, read_only=True)
    _open[path] = identity, library
    return library
