# SPDX-License-Identifier: MIT
"""Folders of a library: the roots that its files lie below, moving them, and forgetting files."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

from shapegoogle_core.api.arguments import as_path, as_paths, check_type, path_text
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.roots.arranging import with_root
from shapegoogle_core.library.roots.keys import key_below
from shapegoogle_core.library.roots.missing import ForgetReport, find_gone
from shapegoogle_core.library.roots.moving import MoveReport, plan_move
from shapegoogle_core.library.roots.paths import (
    absolute_path,
    containing_root,
    joined,
    relative_to,
    spellings,
    top_folders,
)
from shapegoogle_core.library.storage.address import is_database
from shapegoogle_core.library.storage.records import Rearrangement, Root, SourceRecord
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel

__all__ = ["LibraryFolders", "PathLike"]

PathLike = str | os.PathLike[str]


class LibraryFolders:
    """The folders that the files of a library lie below; a base of `Library`.

    Parameters
    ----------
    store : Store
        The open file or database.
    model : ShapeModel
        The model that describes the shapes of this library.

    Attributes
    ----------
    name : str
        Path of the file, or address of the database without its password.
    read_only : bool
        Whether changes are refused: on request, or because the file is write-protected or the role in the
        database may only read.
    """

    def __init__(self, store: Store, model: ShapeModel) -> None:
        self._store = store
        self.model = model
        self.name = store.name
        self.read_only = store.read_only

    @property
    def path(self) -> Path:
        """The file; LibraryError for a library in a database, which has an address instead, its `name`."""
        if is_database(self.name):
            raise LibraryError(f"'{self.name}' is a database, not a file; use its name")
        return Path(self.name)

    def roots(self, *, counted: bool = True) -> list[Root]:
        """Return the named folders that the indexed files lie below.

        Parameters
        ----------
        counted : bool, optional
            Whether to count the sources below each, which takes a while if there are millions.

        Returns
        -------
        roots : list of Root
            In the order of their names.
        """
        return self._store.roots(counted=counted)

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
        roots = self._store.roots(counted=True)
        found = containing_root(path, [root.path for root in roots])
        assert found is not None  # it was there, or has just been made
        return roots[found[0]]

    def map_root(self, name: str, folder: PathLike) -> None:
        """Say where a root lies on this computer, until the library is closed. Nothing is stored.

        A library that several computers use has one path for each root, and Windows, macOS and Linux may
        reach the same folder by different ones.

        Parameters
        ----------
        name : str
            Of a root.
        folder : str or path-like
            Where it is here.

        Raises
        ------
        LibraryError
            If the library has no such root.
        """
        check_type("name", name, str, "a text")
        known = {root.name: root for root in self._store.roots()}
        if name not in known:
            listed = ", ".join(map(repr, sorted(known))) or "none"
            raise LibraryError(f"'{self.name}' has no root {name!r}; its roots: {listed}")
        self._store.map_root(known[name], os.path.realpath(as_path(folder)))

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

    def move(self, old: PathLike, new: PathLike, *, dry_run: bool = False) -> MoveReport:
        """Let all sources below a folder follow it to its new place.

        Files that have not changed are not read again there. If a file is already a source at its new place,
        the two become one if they have the same content, or if only that at the new place still exists.

        Parameters
        ----------
        old : str or path-like
            The folder as it was; it need not exist any more. It may be a root, lie above several, or below
            one.
        new : str or path-like
            The folder as it is now.
        dry_run : bool, optional
            Only report what would be moved, and how many of the files are there.

        Returns
        -------
        report : MoveReport

        Raises
        ------
        LibraryError
            If no source lies below `old`, `new` does not exist or has none of the files, or different files
            would become one source. Then nothing is changed.
        ValueError
            If one of the folders is neither a str nor a path.
        """
        place = as_path(new)
        if not place.is_dir():
            raise LibraryError(f"there is no folder '{place}'; name the folder that '{old}' is now")
        report = plan_move(
            str(as_path(old)),
            os.path.realpath(place),
            self._store.roots(counted=True),
            self._store.sources(),
            lambda path: Path(path).exists(),
        )
        if not dry_run:
            self._store.rearrange(report.changes)
        return report

    def forget(
        self,
        folders: PathLike | Iterable[PathLike] = (),
        *,
        missing: bool = False,
        dry_run: bool = False,
    ) -> ForgetReport:
        """Remove sources with all their shapes: whole folders, single files, labels, or files that are gone.

        No file on disk is touched.

        Parameters
        ----------
        folders : str, path-like, or iterable of them, optional
            Folders, which need not exist any more, and sources. With `missing`, only files below these
            folders are forgotten; by default, below all roots.
        missing : bool, optional
            Forget only the indexed files that no longer exist. A folder that is not there, or empty as where
            a drive is mounted, keeps its files.
        dry_run : bool, optional
            Only report what would be forgotten.

        Returns
        -------
        report : ForgetReport

        Raises
        ------
        LibraryError
            If a folder is neither a source nor has indexed files below it; with `missing`, if it does not
            exist. Then nothing is removed.
        ValueError
            If no folder is named without `missing`, or one is neither a str nor a path.
        """
        # Texts, not paths, which may be labels.
        several = [folders] if isinstance(folders, str | os.PathLike) else folders
        named = [os.path.expanduser(path_text(folder)) for folder in several]  # noqa: PTH111
        sources, roots = self._store.sources(), self._store.roots()
        kept: dict[str, int] = {}
        gone: Iterable[SourceRecord]
        if missing:
            there = [Path(root.path) for root in roots if Path(root.path).is_dir()]
            gone, kept = self._missing(named or there) if named or there else ([], {})
            if not named:
                away = {root.name: root.path for root in roots if Path(root.path) not in there}
                for source in sources:
                    if source.root in away:
                        kept[away[source.root]] = kept.get(away[source.root], 0) + 1
            emptied: list[Root] = []
        elif not named:
            raise ValueError("name the folders or sources to forget, or ask for missing files")
        else:
            gone = {source.key: source for name in named for source in self._named(name, sources)}.values()
            tops = [spelling for name in named for spelling in spellings(name)]
            emptied = [root for root in roots if any(relative_to(root.path, top) is not None for top in tops)]
        if not dry_run and (gone or emptied):
            removed = {source.key for source in gone}
            left = {source.root for source in sources if source.key not in removed}
            self._store.rearrange(
                Rearrangement(
                    removed=tuple(removed),
                    removed_roots=tuple(root.name for root in emptied if root.name not in left),
                )
            )
        return ForgetReport(
            tuple(source.path for source in gone),
            sum(source.shape_count for source in gone),
            tuple(sorted(kept.items())),
        )

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
        missing, _ = self._missing(folders)
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
        return [source.path for source in self._missing(folders)[0]]

    def _missing(self, folders: PathLike | Iterable[PathLike]) -> tuple[list[SourceRecord], dict[str, int]]:
        named = as_paths(folders)
        for folder in named:
            if not Path(absolute_path(str(folder))).is_dir():
                raise LibraryError(
                    f"'{folder}' does not exist, so its files stay in the library; plug in its drive, or use "
                    "`shapegoogle move` if it was moved and `shapegoogle forget` if it is gone for good"
                )
        tops = [spelling for folder in named for spelling in spellings(str(folder))]
        return find_gone(self._store.sources(), tops)

    def _named(self, name: str, sources: Sequence[SourceRecord]) -> list[SourceRecord]:
        """Find the sources that a folder, a file or a label stands for."""
        folders = spellings(name)
        found = [
            source
            for source in sources
            if source.path == name or any(relative_to(source.path, folder) is not None for folder in folders)
        ]
        if not found and not any(root.path in folders for root in self._store.roots()):
            raise LibraryError(
                f"'{name}' is no source of the library, and no indexed file lies below it; "
                "`shapegoogle info` lists its folders"
            )
        return found
