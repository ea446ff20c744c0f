# SPDX-License-Identifier: MIT
"""Requests of a user interface to its worker process: functions whose arguments and results are picklable.

The process that runs them keeps one `Session`, so that only the first request opens a library.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from shapegoogle_core.errors import LibraryError, MeshError
from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.settings import Rank
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature, load_model
from shapegoogle_core.worker.library_state import LibraryState, ShownShape, state_of

__all__ = [
    "Answer",
    "Session",
    "StoredExample",
    "describe",
    "describe_meshes",
    "explain",
    "library_duplicates",
    "library_state",
    "model_of",
    "open_library",
    "query",
    "versions",
    "warm_up",
]

StoredExample = tuple[int, str]
"""Id and name of a shape of a library."""


class Session:
    """Open libraries and loaded models of one process.

    Opening a library reads its codes; a session does so once. A file that was replaced is opened again.
    """

    def __init__(self) -> None:
        # Each library with the device and number of its file, which tell it from another one in its place.
        self._libraries: dict[Path, tuple[tuple[int, int], Library]] = {}
        # The last model that is in no library, with the time of its file.
        self._model: tuple[str, float, ShapeModel] | None = None

    def library(self, path: Path) -> Library:
        """Open a library to read, or return the open one.

        Parameters
        ----------
        path : Path

        Returns
        -------
        library : Library
            Closed by the session.

        Raises
        ------
        LibraryError
            If it cannot be opened.
        """
        status = path.stat() if path.exists() else None
        identity = (0, 0) if status is None else (status.st_dev, status.st_ino)
        if path in self._libraries:
            known, library = self._libraries[path]
            if known == identity:
                return library
            del self._libraries[path]
            library.close()
        library = Library.open(path, read_only=True)
        self._libraries[path] = identity, library
        return library

    def model(self, name: str) -> ShapeModel:
        """Load a model, or return the loaded one.

        Parameters
        ----------
        name : str
            Name or path, as for `load_model`.

        Returns
        -------
        model : ShapeModel

        Raises
        ------
        ModelError
            If it cannot be loaded.
        """
        changed = Path(name).stat().st_mtime if Path(name).is_file() else 0.0
        if self._model is None or self._model[:2] != (name, changed):
            self._model = name, changed, load_model(name)
        return self._model[2]

    def close(self) -> None:
        """Close all libraries."""
        while self._libraries:
            _, (_, library) = self._libraries.popitem()
            library.close()


_SESSION = Session()
"""The session of this process, which starts empty in each."""


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer to a query.

    Attributes
    ----------
    library : Path
        The library that was searched.
    matches : list of Match
        Best first.
    signatures : list of ShapeSignature
        Of the examples that were searched, for `explain`.
    thumbnails : dict of int to bytes
        Pictures as PNG by shape id, for the matches that have one.
    shape_count : int
        Number of shapes in the library.
    area : float
        Area of the query's first example, in squared units.
    examples : int
        Number of examples.
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
    meshes: Sequence[Mesh | ShapeSignature],
    top: int,
    like: Sequence[StoredExample] = (),
    unlike: Sequence[StoredExample] = (),
    *,
    families: bool = False,
    where: Filter | None = None,
    rank: Rank = "both",
    size_factor: float | None = None,
) -> Answer:
    """Find the shapes of a library that are most similar to a mesh, or to several examples.

    Parameters
    ----------
    path : Path
        The library.
    meshes : sequence of Mesh or ShapeSignature
        Examples of the shape that is searched; signatures are those of an earlier `Answer`.
    top : int
        Number of matches.
    like, unlike : sequence of (int, str), optional
        Shapes of the library, by id and name: further examples, and examples of shapes that are not meant.
    families : bool, optional
        Whether to find different shapes, each with the number of its versions.
    where : Filter, optional
        Conditions on the matches. Only those of a kind have evidence.
    rank : {"both", "shape", "kind"}, optional
        What comes first, see `Library.query`.
    size_factor : float, optional
        Largest factor, at least 1, between the size of a match and that of the first example: the root of
        the ratio of their areas.

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
        If there is no example.
    """
    library = _SESSION.library(path)
    signatures = [
        mesh if isinstance(mesh, ShapeSignature) else library.model.describe(mesh, keep_surface=True)
        for mesh in meshes
    ]
    signatures += [_stored_signature(library, example) for example in like]
    if size_factor is not None:
        area = signatures[0].area
        where = replace(where or Filter(), area=(area / size_factor**2, area * size_factor**2))
    matches = library.query(
        signatures,
        top=top,
        explain=0,
        unlike=[_stored_signature(library, example) for example in unlike],
        families=families,
        where=where,
        rank=rank,
    )
    return _answer(library, signatures, matches)


def versions(path: Path, signatures: Sequence[ShapeSignature], match: Match) -> Answer:
    """List the family of a match of a query with ``families=True``; see `Library.versions`.

    Parameters
    ----------
    path : Path
        The library.
    signatures : sequence of ShapeSignature
        See `Answer`.
    match : Match

    Returns
    -------
    answer : Answer
        The match and its versions, without evidence.

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    """
    library = _SESSION.library(path)
    return _answer(library, list(signatures), library.versions(signatures, match, explain=0))


def _answer(library: Library, signatures: list[ShapeSignature], matches: list[Match]) -> Answer:
    pictures = ((match.shape_id, library.thumbnail(match.shape_id)) for match in matches)
    return Answer(
        library=library.path,
        matches=matches,
        signatures=signatures,
        thumbnails={shape_id: png for shape_id, png in pictures if png is not None},
        shape_count=len(library),
        area=signatures[0].area,
        examples=len(signatures),
    )


def explain(
    path: Path,
    signatures: Sequence[ShapeSignature],
    matches: Sequence[Match],
    *,
    where: Filter | None = None,
) -> dict[int, Match]:
    """Compare the surfaces of matches with that of the query.

    Parameters
    ----------
    path : Path
        The library.
    signatures : sequence of ShapeSignature
        See `Answer`.
    matches : sequence of Match
        All of an answer, or a part of it: each takes up to a tenth of a second.
    where : Filter, optional
        That of the query: of several objects that share a mesh, one that meets it is chosen.

    Returns
    -------
    explained : dict of int to Match
        By the id of the shape: the match with its evidence, None where there is no surface to compare, and as
        the placement that fits best shows it.

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    """
    explained = _SESSION.library(path).explain(signatures, matches, len(matches), where=where)
    return {match.shape_id: match for match in explained}


def _stored_signature(library: Library, example: StoredExample) -> ShapeSignature:
    shape_id, name = example
    try:
        return library.signature(shape_id)
    except LibraryError as error:
        raise LibraryError(
            f"the example {name!r} cannot be used: {error}; remove it from the list of examples"
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
        return describe_shape(shape, _SESSION.library(path).model)
    except MeshError as error:
        return str(error)


def describe_meshes(model: ShapeModel | Path | str, meshes: Sequence[Mesh]) -> list[ShapeSignature | str]:
    """Describe several meshes; one that cannot be described costs only itself.

    Parameters
    ----------
    model : ShapeModel, Path or str
        A path is that of a library with its model in it; a text is a name or path as for `load_model`.
    meshes : sequence of Mesh

    Returns
    -------
    signatures : list of ShapeSignature or str
        In the order of the meshes; a sentence for a mesh that cannot be described.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    ModelError
        If the model cannot be loaded.
    """
    model = model_of(model)
    described: list[ShapeSignature | str] = []
    for mesh in meshes:
        try:
            described.append(model.describe(mesh))
        except MeshError as error:
            described.append(str(error))
    return described


def model_of(model: ShapeModel | Path | str) -> ShapeModel:
    """Return a model, that of a library, or one by its name; see `describe_meshes`."""
    if isinstance(model, Path):
        return _SESSION.library(model).model
    return _SESSION.model(model) if isinstance(model, str) else model


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
    return _SESSION.library(path).duplicates(min_similarity)


def library_state(path: Path, shown: Sequence[ShownShape] = ()) -> LibraryState:
    """Look at a library: its size and model, and which of the shapes shown are still in it.

    Parameters
    ----------
    path : Path
        The library, which need not exist.
    shown : sequence of ShownShape, optional

    Returns
    -------
    state : LibraryState

    Raises
    ------
    LibraryError
        If the library cannot be opened or read.
    """
    return state_of(path, _SESSION.library(path) if path.is_file() else None, shown)


def open_library(path: Path) -> Library:
    """Open a library to read, or return the one that this process has open; see `Session.library`."""
    return _SESSION.library(path)


def warm_up() -> None:
    """Load everything that the first request would wait for, except the library: see `library_state`."""
    import scipy.sparse.linalg  # noqa: F401

    import shapegoogle_core.rendering  # noqa: F401
