# SPDX-License-Identifier: MIT
"""`Library`: a collection of shapes in one file, and the search in it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.duplicates.find import find_duplicates
from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
from shapegoogle_core.library.duplicates.settings import EXPLAINED_MEMBERS, MIN_SIMILARITY
from shapegoogle_core.library.duplicates.split_by_evidence import split_by_evidence
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.missing_files import missing_files
from shapegoogle_core.library.search.explain import explain_matches
from shapegoogle_core.library.search.query import Query
from shapegoogle_core.library.search.query_shapes import QueryShapes, as_query_shapes
from shapegoogle_core.library.search.search import Search
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.storage.opening import open_store
from shapegoogle_core.library.storage.records import NewShape, ShapeRecord, SourceRecord
from shapegoogle_core.library.storage.signatures import check_signature, read_signature
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["Library"]

PathLike = str | os.PathLike[str]

# Shapes that a listing reads at once.
PAGE = 1_000
# Matches that are explained at once to find those of a kind.
KIND_PORTION = 10


class Library:
    """Shapes in one SQLite file, with the model that described them. Open it with `Library.open`.

    A library may be open in several programs at once: any number of them read while one writes; a second
    writer waits for the first one's running transaction. A `Library` itself belongs to the thread that opened
    it. After kill -9, a power cut or a full disk the file holds everything whose method had returned.

    Every method raises `LibraryError` when the file cannot be read or written.
    """

    def __init__(self, store: Store, model: ShapeModel, search: SearchSettings | None = None) -> None:
        self._store = store
        self._model = model
        self._settings = SearchSettings() if search is None else search
        self._search = Search(store, model, self._settings)

    @classmethod
    def open(
        cls,
        path: PathLike,
        model: ShapeModel | None = None,
        *,
        read_only: bool = False,
        timeout: float = 30.0,
        search: SearchSettings | None = None,
    ) -> Self:
        """Open a library, or make a new one.

        Parameters
        ----------
        path : str or path-like
            The file. An existing library on a read-only disk opens too; then it can be searched only.
        model : ShapeModel, optional
            For a new library: the model to describe shapes with; left out, the one that ships with the
            package. For an existing one: must be the library's own model; left out, it is taken from the
            library.
        read_only : bool, optional
            Never change the file, and make none.
        timeout : float, optional
            Longest time to wait while another program writes, in seconds.
        search : SearchSettings, optional
            Settings of all searches in this library.

        Returns
        -------
        library : Library
            Also a context manager that closes it.

        Raises
        ------
        LibraryError
            If the path is a folder, lies in no folder or is no library; if the library is damaged, made by a
            newer version or with another model; if there is none and it may not or cannot be made.
        ModelError
            If a new library is to be made and the shipped model cannot be loaded.
        """
        return cls(*open_store(Path(path), model, read_only=read_only, timeout=timeout), search)

    def close(self) -> None:
        """Close the file. Closing twice does no harm."""
        self._store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Library('{self.path}', model {self._model.identifier})"

    @property
    def path(self) -> Path:
        """The file."""
        return Path(self._store.name)

    @property
    def model(self) -> ShapeModel:
        """The model that describes the shapes of this library."""
        return self._model

    @property
    def read_only(self) -> bool:
        """Whether changes are refused: asked for, or because the file is write-protected."""
        return self._store.read_only

    # -- changes --------------------------------------------------------------------------------------------

    def add(
        self,
        mesh: MeshLike,
        name: str = "",
        source: PathLike = "",
        object_name: str = "",
        thumbnail: bytes | None = None,
        tags: Sequence[str] = (),
    ) -> int:
        """Describe a shape and add it.

        Within a source a shape is known by its object name and name: adding it again replaces it. A shape
        without a source is always a new one.

        Parameters
        ----------
        mesh : MeshLike
        name : str, optional
            By default the file name of the source, such as "horse.ply"; without a source, the name of the
            mesh.
        source : str, optional
            Path of the file it comes from.
        object_name : str, optional
            Name of the object inside the source.
        thumbnail : bytes, optional
            A picture as PNG.
        tags : sequence of str, optional
            Labels to filter searches by.

        Returns
        -------
        shape_id : int

        Raises
        ------
        MeshError
            If the model cannot describe the mesh.
        """
        source = os.fspath(source)
        mesh = as_mesh(mesh, name or Path(source).name)
        return self.add_signature(
            self._model.describe(mesh),
            name or Path(source).name or mesh.name,
            source=source,
            object_name=object_name,
            thumbnail=thumbnail,
            tags=tags,
        )

    def add_signature(
        self,
        signature: ShapeSignature,
        name: str,
        source: str = "",
        object_name: str = "",
        thumbnail: bytes | None = None,
        tags: Sequence[str] = (),
    ) -> int:
        """Add a shape that this library's model has described already; else as `add`.

        Raises
        ------
        LibraryError
            If another model made the signature.
        """
        shape = NewShape(signature, name, object_name, thumbnail, tuple(tags))
        check_signature(signature, name, self._model, self._store.name)
        return self._store.add(source, shape)

    def replace_source(
        self,
        path: PathLike,
        *,
        size: int | None,
        mtime_ns: int | None,
        sha256: str | None,
        shapes: Sequence[NewShape[ShapeSignature]] = (),
        error: str | None = None,
    ) -> list[int]:
        """Put in all that a file gives now and forget what it gave before, in one transaction.

        Parameters
        ----------
        path : str or path-like
            The file, as its shapes' `source` will call it.
        size, mtime_ns : int or None
            As `os.stat` gives them, to see later whether the file changed.
        sha256 : str or None
            Hash of its content, in hexadecimal digits.
        shapes : sequence of NewShape, optional
            May be empty: the file is remembered all the same.
        error : str, optional
            Why the file, or a part of it, could not be described.

        Returns
        -------
        shape_ids : list of int
            In the order of `shapes`.
        """
        for shape in shapes:
            check_signature(shape.signature, shape.name, self._model, self._store.name)
        source = SourceRecord(os.fspath(path), size, mtime_ns, sha256, error, len(shapes))
        return self._store.replace_source(source, shapes)

    def update_source(self, path: PathLike, *, size: int, mtime_ns: int) -> bool:
        """Note the new time of a file whose content is still the same; returns whether it is known."""
        return self._store.update_source(os.fspath(path), size, mtime_ns)

    def remove(self, source: PathLike) -> bool:
        """Remove a source with all its shapes; returns whether it was known."""
        return self._store.remove_sources([os.fspath(source)]) > 0

    def remove_shape(self, shape_id: int) -> bool:
        """Remove one shape; returns whether it was there."""
        return self._store.remove_shapes([shape_id]) > 0

    def remove_missing(self, folders: Iterable[PathLike]) -> list[str]:
        """Remove the indexed files that are no longer there. Nothing does this by itself.

        Parameters
        ----------
        folders : iterable of str or path-like
            Only files below these folders are looked at. Each must exist: on a drive that is not plugged in
            all files are missing.

        Returns
        -------
        removed : list of str
            Paths of the removed sources.

        Raises
        ------
        LibraryError
            If a folder does not exist; then nothing is removed.
        """
        missing = self.missing(folders)
        if missing:
            self._store.remove_sources(missing)
        return missing

    def missing(self, folders: Iterable[PathLike]) -> list[str]:
        """List the indexed files that are no longer there.

        Parameters
        ----------
        folders : iterable of str or path-like
            As for `remove_missing`.

        Returns
        -------
        missing : list of str
            Paths of the sources.

        Raises
        ------
        LibraryError
            If a folder does not exist.
        """
        return missing_files(self._store.sources(), folders)

    # -- what is in it --------------------------------------------------------------------------------------

    def __len__(self) -> int:
        return self._store.count()

    def info(self) -> dict[str, object]:
        """Describe the library in numbers.

        Returns
        -------
        info : dict
            ``path``, ``shapes``, ``sources``, ``failed`` (sources with an error), ``model`` (its identifier),
            ``model_name``, ``code_bits``, ``bag_size``, ``bytes`` (of the file), ``schema``.
        """
        summary = self._store.summary()
        return {
            "path": str(self.path),
            "shapes": summary.shapes,
            "sources": summary.sources,
            "failed": summary.failed,
            "model": self._model.identifier,
            "model_name": self._model.name,
            "code_bits": self._model.code_bits,
            "bag_size": self._model.bag_size,
            "bytes": summary.bytes,
            "schema": summary.format,
        }

    def sources(self) -> dict[str, SourceRecord]:
        """All known files by path, those that failed included: what is new or changed is to be indexed."""
        return {source.path: source for source in self._store.sources()}

    def shapes(self) -> Iterator[ShapeRecord]:
        """All shapes, oldest first, without bags and pictures.

        They are read page by page, so that a writer need not wait for whoever looks at them.

        Yields
        ------
        shape : ShapeRecord
        """
        last_id = 0
        while page := self._store.shapes_after(last_id, PAGE):
            yield from page
            last_id = page[-1].shape_id

    def signature(self, shape_id: int) -> ShapeSignature:
        """Signature of a shape, its bags rounded to the precision of the library (11 bits).

        Raises
        ------
        LibraryError
            If there is no such shape.
        """
        signature = read_signature(self._store, self._model, shape_id)
        if signature is None:
            raise self._unknown(shape_id)
        return signature

    def thumbnail(self, shape_id: int) -> bytes | None:
        """Picture of a shape as PNG, or None when it has none.

        Raises
        ------
        LibraryError
            If there is no such shape.
        """
        picture = self._store.thumbnail(shape_id)
        if picture is None and not self._store.shapes([shape_id]):
            raise self._unknown(shape_id)
        return picture

    def _unknown(self, shape_id: int) -> LibraryError:
        return LibraryError(
            f"'{self.path}' has no shape {shape_id}; it was removed or replaced: search again"
        )

    # -- search ---------------------------------------------------------------------------------------------

    def query(
        self,
        shapes: QueryShapes,
        *,
        top: int = 10,
        explain: int = 10,
        exact: bool = False,
        unlike: QueryShapes = (),
        where: Filter | None = None,
    ) -> list[Match]:
        """Find the shapes of the library that are most similar to a shape, or to several examples of one.

        The binary codes of all shapes are compared first (algorithm 2 of the paper), the nearest then by
        their full bags, and the best of these are aligned with the query, if the model takes samples of
        surfaces. `SearchSettings` holds the numbers of candidates; `shapegoogle_core.library.search.query`
        explains the distance to several examples.

        Parameters
        ----------
        shapes : MeshLike, ShapeSignature, or sequence of them
            In any pose, at any size. Several are examples of one thing: shapes near to all of them come
            first. A signature is one of this library's model; described with ``keep_surface=True`` its
            evidence is exact.
        top : int, optional
            Number of matches; fewer are returned if the library has fewer shapes, or fewer pass the filter.
        explain : int, optional
            Number of best matches that get evidence, see `explain`.
        exact : bool, optional
            Compare the full bags of all shapes: no shape can be missed, but the time grows with the library.
        unlike : MeshLike, ShapeSignature, or sequence of them, optional
            Examples of what is not meant: shapes near to one of them fall behind, its copies to the end.
        where : Filter, optional
            Conditions on the matches. To find a kind of evidence, the best `EvidenceSettings.max_filtered`
            matches that meet the other conditions are explained, until `top` have the kind.

        Returns
        -------
        matches : list of Match
            Best first; equal distances in the order of name and source.

        Raises
        ------
        MeshError
            If one of the shapes is no mesh, or the model cannot describe it.
        LibraryError
            If another model made one of the signatures, or if a kind of evidence is asked for and the model
            takes no samples of surfaces.
        ValueError
            If there is no shape, or if `top` is below 1 or `explain` below 0.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         _ = library.add(trimesh.creation.box(), name="box")
        ...         _ = library.add(trimesh.creation.icosphere(2), name="ball")
        ...         [match.name for match in library.query(trimesh.creation.box(), top=1)]
        ['box']
        """
        if top < 1:
            raise ValueError(f"top must be at least 1, not {top}")
        if explain < 0:
            raise ValueError(f"explain must be at least 0, not {explain}")
        kind = None if where is None else where.kind
        if kind is not None and self._model.settings.sample is None:
            raise LibraryError(
                f"'{self._store.name}' keeps no samples of surfaces to find the kind {kind!r} with, because "
                f"its model {self._model.name!r} takes none; leave the kind out"
            )
        examples = self._signatures(shapes, keep_surface=explain > 0 or kind is not None)
        if not examples:
            raise ValueError("there is nothing to search for: give at least one mesh or signature")
        unlike_weight = self._settings.rerank.unlike_weight
        query = Query(self._model, examples, self._signatures(unlike), unlike_weight)
        among = self._store.filtered_ids(where) if where is not None and where.selects_shapes else None
        search = self._search.among_all if exact else self._search.among_nearest_codes
        kept = top if kind is None else max(top, self._settings.evidence.max_filtered)
        matches = search(query, kept, among)
        if where is not None and where.min_similarity is not None:
            least = where.min_similarity
            matches = [match for match in matches if match.similarity >= least]
        if kind is not None:
            return self._of_kind(kind, examples, matches[:kept], top)
        return self.explain(examples, matches[:top], explain)

    def explain(
        self, signatures: Sequence[ShapeSignature], matches: Sequence[Match], count: int | None = None
    ) -> list[Match]:
        """Find the kind of the best matches by comparing surfaces.

        Alignments that the search has found are used again.

        Parameters
        ----------
        signatures : sequence of ShapeSignature
            The examples that were searched for, described with ``keep_surface=True``: without their surface
            the figures are coarser.
        matches : sequence of Match
        count : int, optional
            Number of matches to explain; `EvidenceSettings.explained` by default.

        Returns
        -------
        matches : list of Match
            All of them; the first `count` with `Match.evidence`. Shapes that were removed meanwhile, and all
            shapes of a library whose model keeps no samples, have none.
        """
        settings = self._settings.evidence
        count = settings.explained if count is None else count
        explained = explain_matches(self._store, self._model, signatures, matches[:count], settings)
        return [*explained, *matches[count:]]

    def _signatures(self, shapes: QueryShapes, *, keep_surface: bool = False) -> list[ShapeSignature]:
        """Describe a mesh or several; signatures are checked and kept."""
        signatures = []
        for shape in as_query_shapes(shapes):
            if isinstance(shape, ShapeSignature):
                check_signature(shape, "the query", self._model, self._store.name)
                signatures.append(shape)
            else:
                mesh = as_mesh(shape, name="the query")
                signatures.append(self._model.describe(mesh, keep_surface=keep_surface))
        return signatures

    def _of_kind(
        self, kind: str, examples: Sequence[ShapeSignature], matches: Sequence[Match], top: int
    ) -> list[Match]:
        """Explain matches in portions until enough are of a kind."""
        found: list[Match] = []
        for start in range(0, len(matches), KIND_PORTION):
            portion = matches[start : start + KIND_PORTION]
            explained = self.explain(examples, portion, len(portion))
            found += [
                match for match in explained if match.evidence is not None and match.evidence.kind == kind
            ]
            if len(found) >= top:
                break
        return found[:top]

    def duplicates(
        self,
        min_similarity: float = MIN_SIMILARITY,
        progress: Wrapper = iter,
        *,
        explained: int = EXPLAINED_MEMBERS,
    ) -> list[DuplicateGroup]:
        """Find copied files, the same shape again, and shapes that are hard to tell apart.

        Parameters
        ----------
        min_similarity : float, optional
            Least similarity of a "similar" shape to the first of its group; above 0, at most 1.
        explained : int, optional
            Maximum number of members, other than exact copies, aligned to the first shape of their group.
        progress : callable, optional
            Wraps the loop over the shapes, as tqdm does.

        Returns
        -------
        groups : list of DuplicateGroup
            The largest saving first.

        Raises
        ------
        ValueError
            If `min_similarity` is out of range.
        """
        groups = find_duplicates(self._store, self._model, min_similarity, progress)
        return split_by_evidence(self._store, self._model, groups, explained)
