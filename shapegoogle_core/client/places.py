# SPDX-License-Identifier: MIT
"""Sources of a service, which are named by root and path, and where they are on this computer."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import PurePosixPath
from typing import Any

from shapegoogle_core.client.values import text
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.roots.keys import key_below
from shapegoogle_core.library.roots.paths import is_windows, joined
from shapegoogle_core.library.storage.records import Root

__all__ = ["Places"]


class Places:
    """Roots of a service and the folders that they are here.

    Parameters
    ----------
    names : sequence of str
        Of the roots.

    Attributes
    ----------
    folders : dict of str to str
        Folders by the names of those roots that are known here.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.folders: dict[str, str] = {}

    def roots(self) -> list[Root]:
        """Return the roots; those that are not known here have no path."""
        return [Root(name, self.folders.get(name, "")) for name in sorted(self.names)]

    def source(self, place: Mapping[str, Any]) -> str:
        """Return a source of the service as this computer knows it.

        Parameters
        ----------
        place : mapping
            Texts ``root`` and ``path``.

        Returns
        -------
        source : str
            Full path of a file below a root that is known here; otherwise the name of the root and the path
            below it, such as "assets/chairs/oak.blend", or a label. Never the path of another file.
        """
        root, path = text(place["root"]), text(place["path"])
        # A service must not name files outside the folders that were chosen.
        outside = ".." in path.replace("\\", "/").split("/") or _is_path(path)
        folder = self.folders.get(root)
        if folder is not None and not outside:
            return joined(folder, path)
        named = f"{root}/{path}" if root else path
        return re.split(r"[\\/]", named)[-1] if _is_path(named) else named

    def place(self, source: str) -> dict[str, str] | None:
        """Return how the service names a source.

        Parameters
        ----------
        source : str
            As from `source`, or any spelling of the path of a file.

        Returns
        -------
        place : dict or None
            None for a file that lies below no root.
        """
        known = [Root(name, folder) for name, folder in self.folders.items()]
        key = key_below(source, known) if _is_path(source) else None
        if key is not None:
            return {"root": key.root, "path": key.path}
        if _is_path(source):
            return None
        root, separator, below = source.partition("/")
        if separator and root in self.names:
            return {"root": root, "path": below}
        return {"root": "", "path": source}

    def conditions(self, where: Filter | None) -> dict[str, Any] | None:
        """Return the conditions of a filter as the service takes them.

        Parameters
        ----------
        where : Filter or None

        Returns
        -------
        conditions : dict or None
            None if no shape of the service can meet them: they ask for files that it does not know.
        """
        if where is None:
            return {}
        given = {field.name: getattr(where, field.name) for field in fields(Filter)}
        found = {name: value for name, value in given.items() if value is not None}
        if where.folder is not None:
            folder = self._folder(os.fspath(where.folder))
            if folder is None:
                return None
            found["folder"] = folder
        for name, sources in (("sources", where.sources), ("not_sources", where.not_sources)):
            if sources is None:
                continue
            places = [place for place in map(self.place, sources) if place is not None]
            found[name] = places
            if not places:
                if name == "sources":
                    return None
                del found[name]
        return found

    def _folder(self, folder: str) -> str | None:
        """Return a folder by the name of its root; None if it lies below none."""
        for name, own in self.folders.items():
            if os.path.realpath(folder) == own:
                return name
        place = self.place(folder)
        if place is not None and place["root"]:
            return f"{place['root']}/{place['path']}"
        if PurePosixPath(folder.replace("\\", "/")).parts[:1] in {(name,) for name in self.names}:
            return folder
        # It may be relative to the working directory.
        place = self.place(os.path.realpath(folder))
        return None if place is None else f"{place['root']}/{place['path']}"


def _is_path(source: str) -> bool:
    return source.startswith(("/", "\\")) or is_windows(source)
