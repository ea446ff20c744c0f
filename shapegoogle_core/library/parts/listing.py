# SPDX-License-Identifier: MIT
"""`LibraryListing`: the part of a library that counts, lists and reads shapes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from shapegoogle_core.api.arguments import check_count, check_type
from shapegoogle_core.api.text import counted
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.parts.sources import LibrarySources
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.library.storage.signatures import read_signature
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["PAGE", "LibraryListing"]

PAGE = 1_000
"""Number of shapes that a listing reads at once."""


class LibraryListing(LibrarySources):
    """The shapes that a library has; the base of `LibraryContents`.

    Parameters and attributes are those of `LibrarySources`.
    """

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
