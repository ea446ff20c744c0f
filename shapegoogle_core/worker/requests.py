# SPDX-License-Identifier: MIT
"""Requests of a user interface to its worker process: functions whose arguments and results are picklable.

The process that runs them keeps one `Session`, so that only the first request opens a library.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.settings import Rank
from shapegoogle_core.library.searchable import SearchableLibrary
from shapegoogle_core.library.storage.address import Place
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature
from shapegoogle_core.worker.library_state import LibraryState, ShownShape, state_of
from shapegoogle_core.worker.session import Session, as_address

__all__ = [
    "Answer",
    "StoredExample",
    "changing",
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


_SESSION = Session()
"""The session of this process, which starts empty in each."""


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer to a query.

    Attributes
    ----------
    library : LibraryAddress
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
    object_names : dict of int to tuple of str
        Names of all objects that show a shape, by its id, for matches that several objects show.
    """

    library: LibraryAddress
    matches: list[Match]
    signatures: list[ShapeSignature]
    thumbnails: dict[int, bytes]
    shape_count: int
    area: float
    examples: int
    object_names: dict[int, tuple[str, ...]] = field(default_factory=dict)


def query(
    path: LibraryAddress | Place,
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
    path : LibraryAddress, Path or str
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
    return _answer(as_address(path), library, signatures, matches)


def versions(path: LibraryAddress | Place, signatures: Sequence[ShapeSignature], match: Match) -> Answer:
    """List the family of a match of a query with ``families=True``; see `Library.versions`.

    Parameters
    ----------
    path : LibraryAddress, Path or str
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
    found = library.versions(signatures, match, explain=0)
    return _answer(as_address(path), library, list(signatures), found)


def _answer(
    address: LibraryAddress,
    library: SearchableLibrary,
    signatures: list[ShapeSignature],
    matches: list[Match],
) -> Answer:
    return Answer(
        library=address,
        matches=matches,
        signatures=signatures,
        thumbnails=library.thumbnails([match.shape_id for match in matches]),
        shape_count=len(library),
        area=signatures[0].area,
        examples=len(signatures),
        object_names={
            match.shape_id: tuple(placement.object_name for placement in library.placements(match.shape_id))
            for match in matches
            if match.placement_count > 1
        },
    )


def explain(
    path: LibraryAddress | Place,
    signatures: Sequence[ShapeSignature],
    matches: Sequence[Match],
    *,
    where: Filter | None = None,
) -> dict[int, Match]:
    """Compare the surfaces of matches with that of the query.

    Parameters
    ----------
    path : LibraryAddress, Path or str
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


def _stored_signature(library: SearchableLibrary, example: StoredExample) -> ShapeSignature:
    shape_id, name = example
    try:
        return library.signature(shape_id)
    except LibraryError as error:
        raise LibraryError(
            "the example {name!r} cannot be used: {reason}; remove it from the list of examples",
            name=name,
            reason=error,
        ) from error


def model_of(model: ShapeModel | LibraryAddress | Path | str) -> ShapeModel:
    """Return a model, that of a library, or one by its name.

    Parameters
    ----------
    model : ShapeModel, LibraryAddress, Path or str
        An address or a path is that of a library with its model in it; a text is a name or path as for
        `load_model`.

    Returns
    -------
    model : ShapeModel

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    ModelError
        If the model cannot be loaded.
    """
    if isinstance(model, Path | LibraryAddress):
        return _SESSION.library(model).model
    return _SESSION.model(model) if isinstance(model, str) else model


def library_duplicates(
    path: LibraryAddress | Place, min_similarity: float = MIN_SIMILARITY
) -> list[DuplicateGroup]:
    """Find the duplicates in a library; see `Library.duplicates`.

    Parameters
    ----------
    path : LibraryAddress, Path or str
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


def library_state(path: LibraryAddress | Place, shown: Sequence[ShownShape] = ()) -> LibraryState:
    """Look at a library: its size and model, and which of the shapes shown are still in it.

    Parameters
    ----------
    path : LibraryAddress, Path or str
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
    address = as_address(path)
    is_there = not isinstance(address.place, Path) or address.place.is_file()
    return state_of(address, _SESSION.library(address, look=True) if is_there else None, shown)


def open_library(library: LibraryAddress | Place) -> SearchableLibrary:
    """Open a library to read, or return the one that this process has open; see `Session.library`."""
    return _SESSION.library(library)


@contextmanager
def changing(library: LibraryAddress | Place) -> Iterator[SearchableLibrary]:
    """Open a library to decide in.

    Parameters
    ----------
    library : LibraryAddress, Path or str

    Returns
    -------
    context : context manager
        With the library; a file is open for writing inside it, and a service writes itself.

    Raises
    ------
    LibraryError
        If it cannot be opened.
    """
    address = as_address(library)
    if address.is_service:
        yield _SESSION.library(address)
        return
    with address.open(read_only=False) as opened:
        yield opened


def warm_up() -> None:
    """Load everything that the first request would wait for, except the library: see `library_state`."""
    import scipy.sparse.linalg  # noqa: F401

    import shapegoogle_core.rendering  # noqa: F401
