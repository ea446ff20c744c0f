# SPDX-License-Identifier: MIT
"""What a user interface asks of its worker process: functions whose arguments and results can be sent.

They keep libraries open and models loaded from one question to the next, as long as the process lives, so
that only the first question reads the codes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from shapegoogle_core.errors import LibraryError, MeshError
from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.evidence import Evidence
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature, load_model

__all__ = [
    "Answer",
    "StoredExample",
    "describe",
    "describe_meshes",
    "explain",
    "library_duplicates",
    "query",
    "warm_up",
]

StoredExample = tuple[int, str]
"""Id and name of a shape of a library."""

# Open libraries by path, each with what tells its file from another one put in its place.
_open: dict[Path, tuple[tuple[int, int], Library]] = {}
# Models that are in no library, by the name or path that `load_model` takes, with the time of their file.
_loaded: dict[str, tuple[float, ShapeModel]] = {}


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer to a query.

    Attributes
    ----------
    library : Path
        What was asked.
    matches : list of Match
        Best first.
    signatures : list of ShapeSignature
        Of the examples of what was looked for, for `explain`.
    thumbnails : dict of int to bytes
        Pictures as PNG by shape id, of those matches that have one.
    shape_count : int
        How many shapes the library has.
    area : float
        Of the query, in squared units; of its first example, if it has several.
    examples : int
        How many there were of what is looked for.
    """

    library: Path
    matches: list[Match]
    signatures: list[ShapeSignature]
    thumbnails: dict[int, bytes]
    shape_count: int
    area: float
    examples: int


def query(
    path: Path,
    meshes: Sequence[Mesh],
    top: int,
    like: Sequence[StoredExample] = (),
    unlike: Sequence[StoredExample] = (),
) -> Answer:
    """Find the shapes of a library that are most like a mesh, or like several examples.

    Parameters
    ----------
    path : Path
        The library.
    meshes : sequence of Mesh
        Examples of what is looked for.
    top : int
        How many matches.
    like, unlike : sequence of (int, str), optional
        Shapes of the library, by id and name, as further examples of what is looked for and of what is not.

    Returns
    -------
    answer : Answer

    Raises
    ------
    LibraryError
        If the library cannot be opened or read, or an example is no longer in it.
    MeshError
        If a mesh cannot be described.
    ValueError
        If there is no example of what is looked for.
    """
    library = _library(path)
    signatures = [library.model.describe(mesh, keep_surface=True) for mesh in meshes]
    signatures += [_stored_signature(library, example) for example in like]
    matches = library.query(
        signatures,
        top=top,
        explain=0,
        unlike=[_stored_signature(library, example) for example in unlike],
    )
    pictures = ((match.shape_id, library.thumbnail(match.shape_id)) for match in matches)
    return Answer(
        library=path,
        matches=matches,
        signatures=signatures,
        thumbnails={shape_id: png for shape_id, png in pictures if png is not None},
        shape_count=len(library),
        area=signatures[0].area,
        examples=len(signatures),
    )


def explain(
    path: Path, signatures: Sequence[ShapeSignature], matches: Sequence[Match]
) -> dict[int, Evidence | None]:
    """Compare the surfaces of matches with that of the query.

    Parameters
    ----------
    path : Path
        The library.
    signatures : sequence of ShapeSignature
        See `Answer`.
    matches : sequence of Match
        All of an answer, or a part of it: each takes up to a tenth of a second.

    Returns
    -------
    evidence : dict of int to Evidence or None
        By the id of the shape; None where there is no surface to compare.

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    """
    explained = _library(path).explain(signatures, matches, len(matches))
    return {match.shape_id: match.evidence for match in explained}


def _stored_signature(library: Library, example: StoredExample) -> ShapeSignature:
    shape_id, name = example
    try:
        return library.signature(shape_id)
    except LibraryError as error:
        raise LibraryError(
            f"the example {name!r} cannot be used: {error}; take it off the list of examples"
        ) from error


def describe(path: Path, shape: NewShape[Mesh]) -> NewShape[ShapeSignature] | str:
    """Describe a shape with the model of a library.

    Parameters
    ----------
    path : Path
        The library.
    shape : NewShape
        With its mesh.

    Returns
    -------
    described : NewShape or str
        With its signature and thumbnail; a sentence if it cannot be described.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    """
    from shapegoogle_core.indexing import describe_shape

    try:
        return describe_shape(shape, _library(path).model)
    except MeshError as error:
        return str(error)


def describe_meshes(model: ShapeModel | Path | str, meshes: Sequence[Mesh]) -> list[ShapeSignature | str]:
    """Describe several meshes; one that cannot be described costs only itself.

    Parameters
    ----------
    model : ShapeModel, Path or str
        A path: that of a library, with the model in it. A text: what `load_model` calls a model.
    meshes : sequence of Mesh

    Returns
    -------
    signatures : list of ShapeSignature or str
        In the order of the meshes; a sentence in place of a signature says why there is none.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    ModelError
        If the model cannot be loaded.
    """
    if isinstance(model, Path):
        model = _library(model).model
    elif isinstance(model, str):
        model = _model(model)
    described: list[ShapeSignature | str] = []
    for mesh in meshes:
        try:
            described.append(model.describe(mesh))
        except MeshError as error:
            described.append(str(error))
    return described


def library_duplicates(path: Path, min_similarity: float = MIN_SIMILARITY) -> list[DuplicateGroup]:
    """Find the duplicates in a library; see `Library.duplicates`.

    Parameters
    ----------
    path : Path
        The library.
    min_similarity : float, optional

    Returns
    -------
    groups : list of DuplicateGroup

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    """
    return _library(path).duplicates(min_similarity)


def warm_up(path: Path) -> int:
    """Load what the first question would have to wait for: the library, and what solves eigenproblems.

    Parameters
    ----------
    path : Path
        The library.

    Returns
    -------
    shapes : int
        How many there are; 0 if there is no library yet.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    """
    import scipy.sparse.linalg  # noqa: F401

    import shapegoogle_core.rendering  # noqa: F401

    return len(_library(path)) if path.exists() else 0


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


def _model(name: str) -> ShapeModel:
    changed = Path(name).stat().st_mtime if Path(name).is_file() else 0.0
    if name not in _loaded or _loaded[name][0] != changed:
        _loaded.clear()
        _loaded[name] = changed, load_model(name)
    return _loaded[name][1]
