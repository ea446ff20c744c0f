# SPDX-License-Identifier: MIT
"""`Library`: a collection of shapes in a file or a database, the search in it, and its duplicates."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Self

from shapegoogle_core.api.arguments import check_count, check_number, check_type
from shapegoogle_core.library.decisions.deciding import LibraryDecisions
from shapegoogle_core.library.decisions.in_duplicates import follow_decisions
from shapegoogle_core.library.duplicates.find import find_duplicates
from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
from shapegoogle_core.library.duplicates.settings import EXPLAINED_MEMBERS, MIN_SIMILARITY
from shapegoogle_core.library.duplicates.split_by_evidence import split_by_evidence
from shapegoogle_core.library.neighbours.pairs import distances_among
from shapegoogle_core.library.parts.contents import PathLike
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.search.stages import check_stages
from shapegoogle_core.library.storage.address import as_place
from shapegoogle_core.library.storage.opening import open_store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel

__all__ = ["Library"]


class Library(LibraryDecisions):
    """Shapes in a file or a database, with the model that described them. Open it with `Library.open`.

    A library may be open in several programs at once: any number of them read while one writes; a second
    writer waits for the running transaction of the first. A `Library` itself belongs to the thread that
    opened it. After kill -9, a power cut or a full disk the library holds everything whose method had
    returned.

    Every method raises `LibraryError` if the library cannot be read or written.

    Parameters
    ----------
    store : Store
        The open file or database.
    model : ShapeModel
        The model of the library.
    search : SearchSettings, optional
        Settings of all searches; the default values if left out.

    Examples
    --------
    >>> import tempfile, trimesh
    >>> import shapegoogle_core as sg
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
    ...         _ = library.add(trimesh.creation.box(), name="box")
    ...         match, = library.query(trimesh.creation.box((2, 2, 2)))
    >>> match.name, match.evidence.kind, match.evidence.factor
    ('box', 'scaled', 0.5)
    """

    @classmethod
    def open(
        cls,
        path: PathLike,
        model: ShapeModel | str | Path | None = None,
        *,
        read_only: bool = False,
        timeout: float = 30.0,
        search: SearchSettings | None = None,
    ) -> Self:
        """Open a library, or create a new one.

        Parameters
        ----------
        path : str or path-like
            The file. An existing library on a write-protected disk can be opened too, for searching only.
            Or the URL of a PostgreSQL database, ``postgresql://user@host:5432/name``: parts that are left out
            come from the variables PG…, a service file and ~/.pgpass; ``?schema=NAME`` chooses one of several
            libraries.
        model : ShapeModel, str or Path, optional
            For a new library, the model that describes its shapes, or its name or path as for `load_model`;
            by default the one that ships with the package. For an existing library, its own model, which is
            also the default.
        read_only : bool, optional
            Do not change the library; raise LibraryError if it does not exist.
        timeout : float, optional
            Longest time to wait while another program writes, in seconds.
        search : SearchSettings, optional
            Settings of all searches; the default values if left out.

        Returns
        -------
        library : Library
            Also a context manager that closes it.

        Raises
        ------
        LibraryError
            If the path is a folder, lies in no folder or is not a library; if the database cannot be
            reached; if the library is damaged, made by another version or with another model; if it does not
            exist and cannot be created; if `search` names a stage that is not installed.
        ModelError
            If the model cannot be loaded.
        ValueError
            If an argument is of a wrong type.

        Examples
        --------
        >>> import tempfile
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         len(library)
        0
        """
        check_number("timeout", timeout)
        check_type("search", search, (SearchSettings, type(None)), "a SearchSettings")
        if search is not None:
            check_stages(search)
        return cls(*open_store(as_place(path), model, read_only=read_only, timeout=timeout), search)

    def close(self) -> None:
        """Close the library. Closing twice does no harm."""
        self._store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self.name}', model {self.model.identifier})"

    def distances_among(self, shape_ids: Sequence[int]) -> tuple[list[int], FloatArray]:
        """Compute the distances of all pairs of some shapes, by which lists of matches are sorted.

        Parameters
        ----------
        shape_ids : sequence of int
            A few thousand at most, since the result has a row and a column for each.

        Returns
        -------
        shape_ids : list of n int
            In the order of their numbers, without unknown ones.
        distances : (n, n) array
            Symmetric, with zeros on the diagonal; before surfaces are compared.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         for length in (1, 1.1, 9):
        ...             _ = library.add(trimesh.creation.box((1, 1, length)), name=f"box {length}")
        ...         numbers, distances = library.distances_among([1, 2, 3])
        >>> numbers, bool(distances[0, 1] < distances[0, 2])
        ([1, 2, 3], True)
        """
        return distances_among(self._store, self.model, shape_ids)

    def duplicates(
        self,
        min_similarity: float = MIN_SIMILARITY,
        progress: Wrapper | None = None,
        *,
        explained: int = EXPLAINED_MEMBERS,
    ) -> list[DuplicateGroup]:
        """Find copied files, the same shape again, and shapes that are hard to tell apart.

        Parameters
        ----------
        min_similarity : float, optional
            Least similarity of a "similar" shape to the first of its group; above 0, at most 1.
        progress : callable, optional
            Wraps the loop over the shapes, as tqdm does.
        explained : int, optional
            Maximum number of members, other than exact copies, aligned to the first shape of their group.

        Returns
        -------
        groups : list of DuplicateGroup
            The largest saving first. Shapes of which both are to be kept are not in one group, and a master
            comes first in its group, see `decide`.

        Raises
        ------
        ValueError
            If `min_similarity` or `explained` is out of range.
        LibraryError
            If the library cannot be read, or its service does not answer.
        """
        check_number("min_similarity", min_similarity, most=1, positive=True)
        check_count("explained", explained, 0)
        found = find_duplicates(self._store, self.model, min_similarity, progress or iter)
        groups = follow_decisions(self._store, self.model, found, self._store.decisions())
        return split_by_evidence(self._store, self.model, groups, explained)
