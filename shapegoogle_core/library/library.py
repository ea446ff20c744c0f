# SPDX-License-Identifier: MIT
"""`Library`: a collection of shapes in one file, and the search in it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.duplicates.find import find_duplicates
from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
from shapegoogle_core.library.duplicates.settings import EXPLAINED_MEMBERS, MIN_SIMILARITY
from shapegoogle_core.library.duplicates.split_by_evidence import split_by_evidence
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.missing_files import missing_files
from shapegoogle_core.library.search.explain import EXPLAINED, explain_matches
from shapegoogle_core.library.search.query import Question
from shapegoogle_core.library.search.search import Search
from shapegoogle_core.library.storage.opening import open_store
from shapegoogle_core.library.storage.records import NewShape, ShapeRecord, SourceRecord
from shapegoogle_core.library.storage.samples import unpack_sample
from shapegoogle_core.library.storage.signature_check import check_signature
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["Library"]

PathLike = str | os.PathLike[str]

# Shapes that a listing reads at once.
PAGE = 1_000


class Library:
    """Shapes in one SQLite file, with the model that described them. Open it with `Library.open`.

    A library may be open in several programs at once: any number of them read while one writes; a second
    writer waits for the first one's running transaction. A `Library` itself belongs to the thread that opened
    it. After kill -9, a power cut or a full disk the file holds everything whose method had returned.

    Every method raises `LibraryError` when the file cannot be read or written.
    """

    def __init__(self, store: Store, model: ShapeModel) -> None:
        self._store = store
        self._model = model
        self._search = Search(store, model)

    @classmethod
    def open(
        cls,
        path: PathLike,
        model: ShapeModel | None = None,
        *,
        read_only: bool = False,
        timeout: float = 30.0,
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
            How long to wait while another program writes, in seconds.

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
        return cls(*open_store(Path(path), model, read_only=read_only, timeout=timeout))

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
        mesh: Mesh,
        name: str = "",
        source: str = "",
        object_name: str = "",
        thumbnail: bytes | None = None,
        tags: Sequence[str] = (),
    ) -> int:
        """Describe a shape and add it.

        Within a source a shape is known by its object name and name: adding it again replaces it. A shape
        without a source is always a new one.

        Parameters
        ----------
        mesh : Mesh
        name : str, optional
            What to call it; left out, the mesh's own name.
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
        return self.add_signature(
            self._model.describe(mesh),
            name or mesh.name,
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
        shapes: Sequence[NewShape] = (),
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
        with self._store.snapshot():
            record = self._record(shape_id)
            _, bags = self._store.bags([shape_id], self._model.bag_size)
            samples = self._store.samples([shape_id]) if self._model.settings.sample else {}
            _, codes = self._store.codes("codes", [shape_id], self._model.code_bits // 8)
            local = self._model.settings.local
            local_codes = np.empty((0, 0), np.uint8)
            if local is not None:
                _, local_codes = self._store.codes("local_words", [shape_id], local.words // 8)
        if len(codes) == 0 or len(bags) == 0:
            raise LibraryError(
                f"'{self.path}' is damaged: shape {shape_id} ({record.name!r}) has no signature; index "
                f"{record.source or 'it'!r} again"
            )
        sample = None
        if shape_id in samples:
            sample = unpack_sample(self._store, self._model, shape_id, samples[shape_id])
        return ShapeSignature(
            bags=bags[0],
            code=codes[0],
            area=record.area,
            vertex_count=record.vertex_count,
            face_count=record.face_count,
            sample=sample,
            local_code=local_codes[0] if len(local_codes) else None,
            extents=record.extents,
        )

    def thumbnail(self, shape_id: int) -> bytes | None:
        """Picture of a shape as PNG, or None when it has none.

        Raises
        ------
        LibraryError
            If there is no such shape.
        """
        picture = self._store.thumbnail(shape_id)
        if picture is None:
            self._record(shape_id)
        return picture

    def _record(self, shape_id: int) -> ShapeRecord:
        records = self._store.shapes([shape_id])
        if not records:
            raise LibraryError(
                f"'{self.path}' has no shape {shape_id}; it was removed or replaced: search again"
            )
        return records[0]

    # -- search ---------------------------------------------------------------------------------------------

    def query(
        self,
        mesh: Mesh | Sequence[Mesh],
        top: int = 10,
        exact: bool = False,
        *,
        unlike: Sequence[Mesh] = (),
        explained: int = EXPLAINED,
    ) -> list[Match]:
        """Find the shapes most like a mesh, or like several examples of what is looked for.

        The codes of all shapes are compared first; the `CANDIDATES` nearest (and never fewer than
        `CANDIDATES_PER_MATCH` for each match asked for) are then compared by their full bags. The best of
        these are laid over the query (see `verification`), if the model takes samples of surfaces. What
        several examples mean together is said in `question`.

        Parameters
        ----------
        mesh : Mesh or sequence of Mesh
            In any pose, at any size. Several are examples of one thing: shapes near to all of them come
            first.
        top : int, optional
            How many matches; fewer come back when there are fewer shapes.
        exact : bool, optional
            Compare the full bags of all shapes: nothing can be missed, but it takes time in proportion to the
            size of the library.
        unlike : sequence of Mesh, optional
            Examples of what is not looked for: shapes near to one of them fall behind, its copies to the end.
        explained : int, optional
            So many of the best come with evidence of what kind of match they are; see `explain`.

        Returns
        -------
        matches : list of Match
            Best first; equal distances in the order of name and source.

        Raises
        ------
        MeshError
            If the model cannot describe one of the meshes.
        ValueError
            If there is no mesh, or `top` is below 1.
        """
        meshes = [mesh] if isinstance(mesh, Mesh) else mesh
        signatures = [self._model.describe(example, keep_surface=explained > 0) for example in meshes]
        others = [self._model.describe(example) for example in unlike]
        matches = self.query_signatures(signatures, top, exact, unlike=others)
        return self.explain(signatures, matches, explained)

    def explain(
        self, signatures: Sequence[ShapeSignature], matches: Sequence[Match], count: int = EXPLAINED
    ) -> list[Match]:
        """Say of the best matches what kind of match they are, by checks of geometry.

        Parameters
        ----------
        signatures : sequence of ShapeSignature
            What was asked for, described with `keep_surface`: without it the figures are coarser.
        matches : sequence of Match
        count : int, optional
            How many of them.

        Returns
        -------
        matches : list of Match
            All of them; the first `count` with `Match.evidence`. A shape that was removed meanwhile, and one
            of a library whose model keeps no samples, has none.
        """
        return explain_matches(self._store, self._model, signatures, matches, count)

    def query_signature(self, signature: ShapeSignature, top: int = 10, exact: bool = False) -> list[Match]:
        """Find the shapes most like one that is described already; else as `query`.

        Raises
        ------
        LibraryError
            If another model made the signature.
        """
        return self.query_signatures([signature], top, exact)

    def query_signatures(
        self,
        signatures: Sequence[ShapeSignature],
        top: int = 10,
        exact: bool = False,
        *,
        unlike: Sequence[ShapeSignature] = (),
    ) -> list[Match]:
        """Find the shapes most like several examples that are described already; else as `query`.

        Raises
        ------
        LibraryError
            If another model made one of the signatures.
        """
        if top < 1:
            raise ValueError(f"top must be at least 1, not {top}")
        if not signatures:
            raise ValueError("there is nothing to look for: give at least one example of it")
        for signature in (*signatures, *unlike):
            check_signature(signature, "the query", self._model, self._store.name)
        question = Question(self._model, signatures, unlike)
        if exact:
            return self._search.among_all(question, top)
        return self._search.among_nearest_codes(question, top)

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
