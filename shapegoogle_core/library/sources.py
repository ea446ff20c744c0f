# SPDX-License-Identifier: MIT
"""Sources of a library: the files that its shapes come from, and the roots that they lie below."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

from shapegoogle_core.api.arguments import as_path, as_paths, check_type, path_text
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.roots.arranging import with_root
from shapegoogle_core.library.roots.keys import key_below, source_keys
from shapegoogle_core.library.roots.paths import (
    absolute_path,
    containing_root,
    joined,
    relative_to,
    spellings,
    top_folders,
)
from shapegoogle_core.library.storage.records import NewShape, Rearrangement, Root, SourceKey, SourceRecord
from shapegoogle_core.library.storage.signatures import check_signature
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibrarySources", "PathLike"]

PathLike = str | os.PathLike[str]


class LibrarySources:
    """The sources of a library; a base of `Library`.

    A source is an indexed file, which lies below a root and has one name however its path is spelt; or a
    label, the text that shapes were added under.

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

    # -- roots ----------------------------------------------------------------------------------------------

    def roots(self) -> list[Root]:
        """Return the named folders that the indexed files lie below.

        Returns
        -------
        roots : list of Root
            In the order of their names.
        """
        return self._store.roots()

    def add_root(self, folder: PathLike, name: str = "") -> Root:
        """Make a folder a root; the files below it that are already in the library lie below it from then on.

        Parameters
        ----------
        folder : str or path-like
            Relative to the working directory or absolute; links are followed.
        name : str, optional
            By default the name of the folder, with a number if it is taken. Without a name, a folder that
            lies below a root becomes none of its own.

        Returns
        -------
        root : Root
            The new one, or the one that the folder lies below.

        Raises
        ------
        LibraryError
            If the name belongs to another folder, the folder has another name, or the library cannot be
            written.
        """
        check_type("name", name, str, "a text")
        path = os.path.realpath(as_path(folder))
        changes = with_root(path, name, self._store.roots(), self._store.sources)
        if changes is not None:
            self._store.rearrange(changes)
        roots = self._store.roots()
        found = containing_root(path, [root.path for root in roots])
        assert found is not None  # it was there, or has just been made
        return roots[found[0]]

    def add_roots(self, paths: Iterable[PathLike]) -> None:
        """Make roots for files that lie below none: the topmost of their folders.

        Parameters
        ----------
        paths : iterable of str or path-like
            Files.
        """
        roots = self._store.roots()
        follow = cache(os.path.realpath)
        folders = {
            follow(str(Path(absolute_path(path)).parent))
            for path in map(path_text, paths)
            if key_below(path, roots, follow) is None
        }
        for folder in top_folders(list(folders)):
            self.add_root(folder)

    def source_path(self, path: PathLike) -> str:
        """Return the path that a file has in this library, however it is spelt.

        Parameters
        ----------
        path : str or path-like
            Relative to the working directory or absolute, through links or not.

        Returns
        -------
        path : str
            Absolute.
        """
        return self.source_paths([path])[0]

    def source_paths(self, paths: Iterable[PathLike]) -> list[str]:
        """Return the paths that files have in this library, see `source_path`.

        Parameters
        ----------
        paths : iterable of str or path-like
            In any spelling.

        Returns
        -------
        paths : list of str
            In the same order.
        """
        roots = self._store.roots()
        folders = {root.name: root.path for root in roots}
        follow = cache(os.path.realpath)
        found = []
        for path in map(path_text, paths):
            key = key_below(path, roots, follow)
            found.append(spellings(path, follow)[0] if key is None else joined(folders[key.root], key.path))
        return found

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
        return self._store.replace_source(source, shapes, also=also)

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
        """Give a label another text; its shapes keep their numbers.

        Parameters
        ----------
        source : str
            A label, such as that of a scene that has not been saved yet.
        name : str
            The new text. A label that has it already is replaced.

        Returns
        -------
        known : bool
            Whether the library has the label.
        """
        old, new = SourceKey("", path_text(source)), SourceKey("", path_text(name))
        if not self._store.known_sources([old]):
            return False
        if old != new:
            self._store.rearrange(Rearrangement(moved=((old, new),), removed=(new,)))
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
        missing = self._missing(folders)
        if missing:
            self._store.remove_sources([source.key for source in missing])
        return [source.path for source in missing]

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
        return [source.path for source in self._missing(folders)]

    # -- contents -------------------------------------------------------------------------------------------

    def sources(self) -> dict[str, SourceRecord]:
        """Return all known files, including those that failed.

        Returns
        -------
        sources : dict of str to SourceRecord
            By path.
        """
        return {source.path: source for source in self._store.sources()}

    def _missing(self, folders: PathLike | Iterable[PathLike]) -> list[SourceRecord]:
        named = as_paths(folders)
        for folder in named:
            if not folder.is_dir():
                raise LibraryError(
                    f"'{folder}' does not exist, so its files stay in the library; plug in its drive, or "
                    "name another folder"
                )
        tops = [spelling for folder in named for spelling in spellings(str(folder))]
        return [
            source
            for source in self._store.sources()
            # Only indexed files have a size; other sources are names that need not be paths.
            if source.size is not None
            and any(relative_to(source.path, top) for top in tops)
            and _is_gone(source.path)
        ]

    def _known(self, source: str) -> SourceKey | None:
        """Return the key of a source, None if it is unknown."""
        return next(iter(self._store.known_sources(source_keys(source, self._store.roots()))), None)


def _is_gone(path: str) -> bool:
    """Return whether a file certainly does not exist; one that cannot be reached may exist."""
    try:
        Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        return True
    except OSError:
        return False
    return False
