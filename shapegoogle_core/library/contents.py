# SPDX-License-Identifier: MIT
"""Contents of a library: adding, replacing, removing and listing shapes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from shapegoogle_core.api.arguments import as_tuple, check_count, check_type, path_text
from shapegoogle_core.api.text import counted
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.sources import LibrarySources, PathLike
from shapegoogle_core.library.storage.records import NewShape, ShapeRecord, SourceKey
from shapegoogle_core.library.storage.signatures import check_signature, read_signature
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibraryContents", "PathLike"]

# Shapes that a listing reads at once.
PAGE = 1_000


class LibraryContents(LibrarySources):
    """The shapes of a library and the files they come from; the base of `Library`.

    Parameters and attributes are those of `LibrarySources`.
    """

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
            The file it comes from: the path of an indexed file, or any other text, which is kept as it is.
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
        source = path_text(source)
        shape_id = self._store.add(self._known(source) or SourceKey("", source) if source else None, shape)
        self._added([shape_id])
        return shape_id

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

    # -- contents -------------------------------------------------------------------------------------------

    def __len__(self) -> int:
        return self._store.count()

    def info(self) -> dict[str, object]:
        """Describe the library in numbers.

        Returns
        -------
        info : dict
            ``path``, ``shapes``, ``sources``, ``failed`` (sources with an error), ``model`` (its identifier),
            ``model_name``, ``code_bits``, ``bag_size``, ``bytes`` (of the file), ``schema``,
            ``without_views`` (shapes that an earlier version described), ``roots`` (a list of objects with
            ``name``, ``path`` and ``sources``).
        """
        summary = self._store.summary()
        return {
            "path": self.name,
            "shapes": summary.shapes,
            "sources": summary.sources,
            "failed": summary.failed,
            "model": self.model.identifier,
            "model_name": self.model.name,
            "code_bits": self.model.code_bits,
            "bag_size": self.model.bag_size,
            "bytes": summary.bytes,
            "schema": summary.format,
            "without_views": self.count_without_views(),
            "roots": [
                {"name": root.name, "path": root.path, "sources": root.source_count} for root in self.roots()
            ],
        }

    def count_without_views(self) -> int:
        """Count the shapes that an earlier version of Shape Google described, without views.

        Returns
        -------
        count : int
            0 if the library's model does not describe views.
        """
        return 0 if self.model.views is None else self._store.count_without_views()

    def reindexing_advice(self) -> str:
        """Say what to do if shapes have no views.

        Returns
        -------
        sentence : str
            Empty if there is nothing to do.
        """
        count = self.count_without_views()
        if count == 0:
            return ""
        return (
            f"views are missing for {count:,} of {counted(self._store.count(), 'shape')}, described by an "
            "earlier version of Shape Google; index their folders again to find more of the same kind"
        )

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

    def find(self, where: Filter | None = None, *, after: int = 0, limit: int = 100) -> list[ShapeRecord]:
        """List shapes that meet the conditions of a filter, without a search.

        Parameters
        ----------
        where : Filter, optional
            Conditions; those on kind and similarity need a search and are not used.
        after : int, optional
            Number of the last shape of the page before.
        limit : int, optional
            Maximum number of shapes.

        Returns
        -------
        shapes : list of ShapeRecord
            In the order of their numbers.

        Raises
        ------
        ValueError
            If `limit` is below 1, or an argument is of a wrong type.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         for name in ("oak chair", "table", "chair"):
        ...             _ = library.add(trimesh.creation.box(), name=name)
        ...         [shape.name for shape in library.find(sg.Filter(name="chair"))]
        ['oak chair', 'chair']
        """
        check_count("limit", limit, 1)
        check_type("where", where, (Filter, type(None)), "a shapegoogle_core.Filter")
        if where is None or not where.selects_shapes:
            return self._store.shapes_after(after, limit)
        found = self._store.filtered_ids(where)
        return self._store.shapes(found[found > after][:limit].tolist())

    def has_shape(self, shape_id: int) -> bool:
        """Return whether there is a shape.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        there : bool
        """
        return bool(self._store.shapes([shape_id]))

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

    def shape(self, shape_id: int) -> ShapeRecord:
        """Return the record of a shape.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        shape : ShapeRecord

        Raises
        ------
        LibraryError
            If there is no such shape.
        """
        records = self._store.shapes([shape_id])
        if not records:
            raise self._unknown(shape_id)
        return records[0]

    def records(self, shape_ids: Sequence[int]) -> list[ShapeRecord]:
        """Return the records of several shapes.

        Parameters
        ----------
        shape_ids : sequence of int
            See `ShapeRecord`.

        Returns
        -------
        shapes : list of ShapeRecord
            In the order of the numbers; without those that are no shapes of this library.

        Raises
        ------
        LibraryError
            If the library cannot be read, or its service does not answer.
        """
        return self._store.shapes(list(shape_ids))

    def placements(self, shape_id: int) -> tuple[Placement, ...]:
        """Return the objects that show a shape, and where.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        placements : tuple of Placement
            Empty for a file without objects.

        Raises
        ------
        LibraryError
            If there is no such shape.
        """
        placements = self._store.placements([shape_id]).get(shape_id)
        if placements is None and not self._store.shapes([shape_id]):
            raise self._unknown(shape_id)
        return placements or ()

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

    def thumbnails(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """Return the pictures of several shapes.

        Parameters
        ----------
        shape_ids : sequence of int
            See `ShapeRecord`.

        Returns
        -------
        pictures : dict of int to bytes
            As PNG, by number; without the shapes that have none, or are not in the library.

        Raises
        ------
        LibraryError
            If the library cannot be read, or its service does not answer.
        """
        pictures = ((number, self._store.thumbnail(number)) for number in shape_ids)
        return {number: picture for number, picture in pictures if picture is not None}

    def _unknown(self, shape_id: int) -> LibraryError:
        return LibraryError(
            "'{library}' has no shape {number}; it was removed or replaced: search again",
            library=self.name,
            number=shape_id,
        )


def _check_labels(name: str, object_name: str, thumbnail: bytes | None, tags: str | Sequence[str]) -> None:
    """Raise ValueError if what is stored with a shape is of a wrong type."""
    check_type("name", name, str, "a text")
    check_type("object_name", object_name, str, "a text")
    check_type("thumbnail", thumbnail, (bytes, type(None)), "the bytes of a PNG file")
    as_tuple("tags", tags, str, "a text, or several")
