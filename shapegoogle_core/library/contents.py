# SPDX-License-Identifier: MIT
"""Contents of a library: adding, replacing, removing and listing shapes."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from shapegoogle_core.api.arguments import as_paths, as_tuple, check_type, path_text
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.records import NewShape, ShapeRecord, SourceRecord
from shapegoogle_core.library.storage.signatures import check_signature, read_signature
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibraryContents", "PathLike"]

PathLike = str | os.PathLike[str]

# Shapes that a listing reads at once.
PAGE = 1_000


class LibraryContents:
    """The shapes of a library and the files they come from; the base of `Library`.

    Parameters
    ----------
    store : Store
        The open file.
    model : ShapeModel
        The model that describes the shapes of this library.

    Attributes
    ----------
    path : Path
        The file.
    read_only : bool
        Whether changes are refused: on request, or because the file is write-protected.
    """

    def __init__(self, store: Store, model: ShapeModel) -> None:
        self._store = store
        self.model = model
        self.path = Path(store.name)
        self.read_only = store.read_only

    # -- changes --------------------------------------------------------------------------------------------

    def add(
        self,
        mesh: MeshLike,
        name: str = "",
        source: PathLike = "",
        object_name: str = "",
        thumbnail: bytes | None = None,
        tags: str | Sequence[str] = (),
    ) -> int:
        """Describe a shape and add it.

        Within a source a shape is known by its object name and name: adding it again replaces it. A shape
        without a source is always a new one.

        Parameters
        ----------
        mesh : MeshLike
            A `Mesh`, a tuple ``(vertices, faces)``, or an object with ``.vertices`` and ``.faces``.
        name : str, optional
            By default the file name of the source, such as "horse.ply"; without a source, the name of the
            mesh.
        source : str or path-like, optional
            Path of the file it comes from.
        object_name : str, optional
            Name of the object inside the source.
        thumbnail : bytes, optional
            A picture as PNG.
        tags : str or sequence of str, optional
            Labels to filter searches by.

        Returns
        -------
        shape_id : int
            Number of the shape; never given to another shape of this library.

        Raises
        ------
        MeshError
            If it is not a mesh, or the model cannot describe it.
        LibraryError
            If the file cannot be written.
        ValueError
            If another argument is of a wrong type.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         _ = library.add(trimesh.creation.box(), source="models/box.stl", tags=["wood"])
        ...         [shape.name for shape in library.shapes()]
        ['box.stl']
        """
        source = path_text(source)
        # Before the mesh is described, which takes longer.
        _check_labels(name, object_name, thumbnail, tags)
        mesh = as_mesh(mesh, name or Path(source).name)
        return self.add_signature(
            self.model.describe(mesh),
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
        source: PathLike = "",
        object_name: str = "",
        thumbnail: bytes | None = None,
        tags: str | Sequence[str] = (),
    ) -> int:
        """Add a shape that the model of this library has described already; otherwise like `add`.

        Parameters
        ----------
        signature : ShapeSignature
            From `ShapeModel.describe`.
        name : str
            Name of the object or of the file.
        source, object_name, thumbnail, tags
            See `add`.

        Returns
        -------
        shape_id : int
            Number of the shape; never given to another shape of this library.

        Raises
        ------
        LibraryError
            If another model made the signature, or the file cannot be written.
        ValueError
            If another argument is of a wrong type.
        """
        _check_labels(name, object_name, thumbnail, tags)
        tags = as_tuple("tags", tags, str, "a text, or several")
        shape = NewShape(signature, name, object_name, thumbnail, tags)
        check_signature(signature, name, self.model, self._store.name)
        return self._store.add(path_text(source), shape)

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
        """Store the shapes of a file in place of those stored for it before, in one transaction.

        Parameters
        ----------
        path : str or path-like
            The file; becomes the `source` of its shapes.
        size, mtime_ns : int or None
            From `os.stat`, to see later whether the file has changed.
        sha256 : str or None
            Hash of its content, in hexadecimal digits.
        shapes : sequence of NewShape, optional
            Its shapes; the file is remembered even without any.
        error : str, optional
            Reason why the file, or a part of it, could not be described.

        Returns
        -------
        shape_ids : list of int
            In the order of `shapes`.

        Raises
        ------
        LibraryError
            If another model described one of the shapes, or the file cannot be written.
        """
        for shape in shapes:
            check_signature(shape.signature, shape.name, self.model, self._store.name)
        source = SourceRecord(path_text(path), size, mtime_ns, sha256, error, len(shapes))
        return self._store.replace_source(source, shapes)

    def update_source(self, path: PathLike, *, size: int, mtime_ns: int) -> bool:
        """Store the new time of a file whose content is still the same.

        Parameters
        ----------
        path : str or path-like
            The file.
        size, mtime_ns : int
            From `os.stat`.

        Returns
        -------
        known : bool
            Whether the file is a source of this library.
        """
        return self._store.update_source(path_text(path), size, mtime_ns)

    def remove(self, source: PathLike) -> bool:
        """Remove a source with all its shapes.

        Parameters
        ----------
        source : str or path-like
            Path of the file.

        Returns
        -------
        known : bool
            Whether it was a source of this library.
        """
        return self._store.remove_sources([path_text(source)]) > 0

    def remove_shape(self, shape_id: int) -> bool:
        """Remove one shape.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        known : bool
            Whether there was such a shape.
        """
        return self._store.remove_shapes([shape_id]) > 0

    def remove_missing(self, folders: PathLike | Iterable[PathLike]) -> list[str]:
        """Remove the indexed files that no longer exist. This never happens without a request.

        Parameters
        ----------
        folders : str, path-like, or iterable of them
            Only files below these folders are checked. Each folder must exist: on a drive that is not
            connected all files are missing.

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

    def missing(self, folders: PathLike | Iterable[PathLike]) -> list[str]:
        """List the indexed files that no longer exist.

        Parameters
        ----------
        folders : str, path-like, or iterable of them
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
        roots = [folder.resolve() for folder in as_paths(folders)]
        for root in roots:
            if not root.is_dir():
                raise LibraryError(
                    f"'{root}' does not exist, so its files stay in the library; plug in its drive, or name "
                    "another folder"
                )
        return [
            source.path
            for source in self._store.sources()
            # Only indexed files have a size; other sources are names that need not be paths.
            if source.size is not None
            and any(Path(source.path).resolve().is_relative_to(root) for root in roots)
            and _is_gone(source.path)
        ]

    # -- contents -------------------------------------------------------------------------------------------

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
            "model": self.model.identifier,
            "model_name": self.model.name,
            "code_bits": self.model.code_bits,
            "bag_size": self.model.bag_size,
            "bytes": summary.bytes,
            "schema": summary.format,
        }

    def sources(self) -> dict[str, SourceRecord]:
        """Return all known files, including those that failed.

        Returns
        -------
        sources : dict of str to SourceRecord
            By path.
        """
        return {source.path: source for source in self._store.sources()}

    def shapes(self) -> Iterator[ShapeRecord]:
        """Iterate over the records of all shapes, oldest first.

        They are read page by page, so that a writer need not wait for a slow reader.

        Yields
        ------
        shape : ShapeRecord
            Without its signature and thumbnail.
        """
        last_id = 0
        while page := self._store.shapes_after(last_id, PAGE):
            yield from page
            last_id = page[-1].shape_id

    def signature(self, shape_id: int) -> ShapeSignature:
        """Return the signature of a shape.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        signature : ShapeSignature
            Its bags are rounded to the precision of the library (11 bits).

        Raises
        ------
        LibraryError
            If there is no such shape.
        """
        signature = read_signature(self._store, self.model, shape_id)
        if signature is None:
            raise self._unknown(shape_id)
        return signature

    def thumbnail(self, shape_id: int) -> bytes | None:
        """Return the picture of a shape.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        picture : bytes or None
            As PNG; None for a shape without a picture.

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


def _check_labels(name: str, object_name: str, thumbnail: bytes | None, tags: str | Sequence[str]) -> None:
    """Raise ValueError if what is stored with a shape is of a wrong type."""
    check_type("name", name, str, "a text")
    check_type("object_name", object_name, str, "a text")
    check_type("thumbnail", thumbnail, (bytes, type(None)), "the bytes of a PNG file")
    as_tuple("tags", tags, str, "a text, or several")


def _is_gone(path: str) -> bool:
    """Return whether a file certainly does not exist; one that cannot be reached may exist."""
    try:
        Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        return True
    except OSError:
        return False
    return False
