# SPDX-License-Identifier: MIT
"""Sources of a library: the files and labels that its shapes come from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from shapegoogle_core.api.arguments import path_text
from shapegoogle_core.library.parts.folders import LibraryFolders, PathLike
from shapegoogle_core.library.roots.keys import key_below, source_keys
from shapegoogle_core.library.storage.records import NewShape, Rearrangement, SourceKey, SourceRecord
from shapegoogle_core.library.storage.signatures import check_signature
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibrarySources", "PathLike"]


class LibrarySources(LibraryFolders):
    """The sources of a library; a base of `Library`.

    A source is an indexed file, which lies below a root and has one name however its path is spelt; or a
    label, the text that shapes were added under. Parameters and attributes are those of `LibraryFolders`.
    """

    # -- changes --------------------------------------------------------------------------------------------

    def replace_source(
        self,
        path: PathLike,
        *,
        size: int | None,
        mtime_ns: int | None,
        sha256: str | None,
        shapes: Sequence[NewShape[ShapeSignature]] = (),
        error: str | None = None,
        claim: bool = False,
    ) -> list[int]:
        """Store the shapes of a file in place of those stored for it before, in one transaction.

        Parameters
        ----------
        path : str or path-like
            The file; becomes the `source` of its shapes. With a size it lies below one of the roots, if one
            contains it; any other text is a label, which is kept as it is.
        size, mtime_ns : int or None
            From `os.stat`, to see later whether the file has changed.
        sha256 : str or None
            Hash of its content, in hexadecimal digits.
        shapes : sequence of NewShape, optional
            Its shapes; the file is remembered even without any.
        error : str, optional
            Reason why the file, or a part of it, could not be described.
        claim : bool, optional
            Leave everything as it is if another program has stored the same content of this file meanwhile.

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
        path = path_text(path)
        known = self._known(path)
        below = None if size is None else key_below(path, self._store.roots())
        key = below or known or SourceKey("", path)
        # A file whose shapes were added under its path before it was indexed is one source all the same.
        also = known if known != key else None
        source = SourceRecord.of(key, size, mtime_ns, sha256, error)
        shape_ids = self._store.replace_source(source, shapes, also=also, claim=claim)
        self._added(shape_ids)
        return shape_ids

    def _added(self, shape_ids: Sequence[int]) -> None:
        """Do what follows when shapes were added; a class that searches relates them to the others."""

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
        known = self._known(path_text(path))
        return known is not None and self._store.update_source(known, size, mtime_ns)

    def rename_source(self, source: str, name: str) -> bool:
        """Give a label another text, or its shapes to a file; they keep their numbers.

        Parameters
        ----------
        source : str
            A label, such as that of a scene that has not been saved yet.
        name : str
            The new text. The absolute path of a file below a root makes them shapes of that file. A source
            that has the name already is replaced.

        Returns
        -------
        known : bool
            Whether the library has the label.
        """
        old, label = SourceKey("", path_text(source)), SourceKey("", path_text(name))
        if not self._store.known_sources([old]):
            return False
        below = key_below(name, self._store.roots()) if Path(name).is_absolute() else None
        new = below or label
        if old != new:
            replaced = tuple(key for key in (new, label) if key != old)
            self._store.rearrange(Rearrangement(moved=((old, new),), removed=replaced))
        return True

    def remove(self, source: PathLike) -> bool:
        """Remove a source with all its shapes.

        Parameters
        ----------
        source : str or path-like
            Path of the file, or label.

        Returns
        -------
        known : bool
            Whether it was a source of this library.
        """
        known = self._known(path_text(source))
        return known is not None and self._store.remove_sources([known]) > 0

    # -- contents -------------------------------------------------------------------------------------------

    def sources(self) -> dict[str, SourceRecord]:
        """Return all known files, including those that failed.

        Returns
        -------
        sources : dict of str to SourceRecord
            By path.
        """
        return {source.path: source for source in self._store.sources()}

    def source_of(self, shape_id: int) -> SourceRecord | None:
        """Return the file, or the label, that a shape comes from.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        source : SourceRecord or None
            None for a shape without a source, or if there is no such shape.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         box = library.add(trimesh.creation.box(), name="box", source="boxes")
        ...         library.source_of(box).path
        'boxes'
        """
        return self._store.source_of(shape_id)

    def sources_without_views(self) -> frozenset[str]:
        """Return the sources of shapes without views, which an earlier version of Shape Google described.

        Returns
        -------
        paths : frozenset of str
            Keys of `sources`. None if the library's model does not describe views either.
        """
        if self.model.views is None or self._store.count_without_views() == 0:
            return frozenset()
        lacking = set(self._store.sources_without_views())
        return frozenset(source.path for source in self._store.sources() if source.key in lacking)

    def _known(self, source: str) -> SourceKey | None:
        """Return the key of a source, None if it is unknown."""
        return next(iter(self._store.known_sources(source_keys(source, self._store.roots()))), None)
