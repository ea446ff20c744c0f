# SPDX-License-Identifier: MIT
"""Libraries and models that a process keeps open from one request to the next."""

from __future__ import annotations

from pathlib import Path

from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel, load_model

__all__ = ["Session"]


class Session:
    """Open libraries and loaded models of one process.

    Opening a library reads its codes; a session does so once. A file that was replaced is opened again.
    """

    def __init__(self) -> None:
        # Each library with the device and number of its file, which tell it from another one in its place.
        self._libraries: dict[Path, tuple[tuple[int, int], Library]] = {}
        # The last model that is in no library, with the time of its file.
        self._model: tuple[str, float, ShapeModel] | None = None

    def library(self, path: Path) -> Library:
        """Open a library to read, or return the open one.

        Parameters
        ----------
        path : Path

        Returns
        -------
        library : Library
            Closed by the session.

        Raises
        ------
        LibraryError
            If it cannot be opened.
        """
        status = path.stat() if path.exists() else None
        identity = (0, 0) if status is None else (status.st_dev, status.st_ino)
        if path in self._libraries:
            known, library = self._libraries[path]
            if known == identity:
                return library
            del self._libraries[path]
            library.close()
        library = Library.open(path, read_only=True)
        self._libraries[path] = identity, library
        return library

    def model(self, name: str) -> ShapeModel:
        """Load a model, or return the loaded one.

        Parameters
        ----------
        name : str
            Name or path, as for `load_model`.

        Returns
        -------
        model : ShapeModel

        Raises
        ------
        ModelError
            If it cannot be loaded.
        """
        changed = Path(name).stat().st_mtime if Path(name).is_file() else 0.0
        if self._model is None or self._model[:2] != (name, changed):
            self._model = name, changed, load_model(name)
        return self._model[2]

    def close(self) -> None:
        """Close all libraries."""
        while self._libraries:
            _, (_, library) = self._libraries.popitem()
            library.close()
