# SPDX-License-Identifier: MIT
"""What a user interface has another process do: functions whose arguments and results can be sent.

They keep libraries open from one question to the next, each as long as the process lives, so that only the
first question reads the codes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from shapegoogle_core.errors import MeshError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.match import Match
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeSignature

__all__ = ["Answer", "Description", "describe", "kind_of_match", "query", "warm_up"]

# Distance of bags that are the same but for the half floats of the library and other rounding.
SAME_BAG = 1e-4
# Relative difference of sizes that is none.
SAME_SIZE = 1e-3
# Similarity from which a match is more likely the same shape than the nearest of many others.
LIKELY = 0.5

# Open libraries by path, each with what tells its file from another one put in its place.
_open: dict[Path, tuple[tuple[int, int], Library]] = {}


@dataclass(frozen=True)
class Answer:
    """The answer to a query.

    Attributes
    ----------
    matches : list of Match
        Best first.
    kinds : dict of int to str
        What kind of match each shape is, by its id; see `kind_of_match`.
    thumbnails : dict of int to bytes
        Pictures as PNG by shape id, of those matches that have one.
    shape_count : int
        How many shapes the library has.
    area : float
        Of the query, in squared units.
    """

    matches: list[Match]
    kinds: dict[int, str]
    thumbnails: dict[int, bytes]
    shape_count: int
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
    return Answer(
        matches=matches,
        kinds={match.shape_id: kind_of_match(signature, match) for match in matches},
        thumbnails={shape_id: png for shape_id, png in pictures if png is not None},
        shape_count=len(library),
        area=signature.area,
    )


def kind_of_match(query: ShapeSignature, match: Match) -> str:
    """Say what a match probably is, by distance, counts and area alone; no geometry is compared.

    Parameters
    ----------
    query : ShapeSignature
    match : Match

    Returns
    -------
    kind : str
        "Same mesh" (as many vertices and faces, and the same bag), with the factor of its size if that is
        another; "Same mesh, re-posed" (as many vertices and faces, and likely the same shape); "Same shape"
        (likely, of another mesh); "Similar".
    """
    same_counts = (query.vertex_count, query.face_count) == (match.vertex_count, match.face_count)
    size = float((match.area / query.area) ** 0.5)
    if same_counts and match.distance <= SAME_BAG:
        return "Same mesh" if abs(size - 1) <= SAME_SIZE else f"Same mesh, ×{size:.3g}"
    if match.similarity >= LIKELY:
        return "Same mesh, re-posed" if same_counts else "Same shape"
    return "Similar"


@dataclass(frozen=True, eq=False)
class Description:
    """A shape ready to be put into a library.

    Attributes
    ----------
    signature : ShapeSignature
    thumbnail : bytes
        A picture as PNG.
    """

    signature: ShapeSignature
    thumbnail: bytes


def describe(path: Path, mesh: Mesh, up_axis: int | None = None) -> Description | str:
    """Describe a mesh with the model of a library.

    Parameters
    ----------
    path : Path
        The library.
    mesh : Mesh
    up_axis : int, optional
        Which axis points up in the picture, 1 or 2, where that is known.

    Returns
    -------
    description : Description or str
        A sentence on why, if the mesh cannot be described.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    """
    from shapegoogle_core.rendering import thumbnail

    try:
        return Description(_library(path).model.describe(mesh), thumbnail(mesh, up_axis=up_axis))
    except MeshError as error:
        return str(error)


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
