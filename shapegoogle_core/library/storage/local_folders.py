# SPDX-License-Identifier: MIT
"""Where the roots of a library lie on this computer, if not where the library says."""

from __future__ import annotations

from shapegoogle_core.library.storage.records import Root

__all__ = ["LocalFolders"]


class LocalFolders:
    """Local paths of roots. Nothing of it is stored."""

    def __init__(self) -> None:
        self._by_name: dict[str, str] = {}
        self._by_stored: dict[str, str] = {}

    def put(self, root: Root, path: str) -> None:
        """Let a root lie at a path.

        Parameters
        ----------
        root : Root
            As it is stored, or mapped already.
        path : str
            Absolute.
        """
        self._by_name[root.name] = path
        self._by_stored[root.key_folder] = path

    def of(self, stored: str) -> str:
        """Return the local path of a root.

        Parameters
        ----------
        stored : str
            Path that the library has for it.

        Returns
        -------
        path : str
        """
        return self._by_stored.get(stored, stored)

    def root(self, name: str, stored: str, source_count: int) -> Root:
        """Make the record of a root.

        Parameters
        ----------
        name : str
        stored : str
            Path that the library has for it.
        source_count : int

        Returns
        -------
        root : Root
        """
        path = self._by_name.get(name, stored)
        if path == stored:
            return Root(name, path, source_count)
        self._by_stored[stored] = path  # another program may have moved it
        return Root(name, path, source_count, stored)
