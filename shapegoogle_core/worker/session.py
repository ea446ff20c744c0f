# SPDX-License-Identifier: MIT
"""`Session`: libraries and models that a long-running process keeps open."""

from __future__ import annotations

import time
from pathlib import Path

from shapegoogle_core.client import LibraryAddress, ServiceLibrary
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.searchable import SearchableLibrary
from shapegoogle_core.library.storage.address import Place
from shapegoogle_core.model import ShapeModel, load_model

__all__ = ["Session", "as_address"]

# Between questions whether a service still has the same library.
_SECONDS_BETWEEN_LOOKS = 60.0


class Session:
    """Open libraries and loaded models of one process.

    Opening a library reads its codes, and connecting to a service its model; a session does so once. A file
    that was replaced is opened again.
    """

    def __init__(self) -> None:
        # Each library with the device and number of its file, which tell it from another one in its place.
        self._libraries: dict[LibraryAddress, tuple[tuple[int, int], SearchableLibrary]] = {}
        # When a service was last asked whether it is the same.
        self._asked: dict[LibraryAddress, float] = {}
        # The last model that is in no library, with the time of its file.
        self._model: tuple[str, float, ShapeModel] | None = None

    def library(self, library: LibraryAddress | Place, *, look: bool = False) -> SearchableLibrary:
        """Open a library to read, or return the open one.

        Parameters
        ----------
        library : LibraryAddress, Path or str
        look : bool, optional
            Whether to ask a service in any case whether it still is what it was; otherwise it is asked every
            now and then.

        Returns
        -------
        opened : SearchableLibrary
            Closed by the session.

        Raises
        ------
        LibraryError
            If it cannot be opened.
        """
        address = as_address(library)
        if address.refusal:
            raise LibraryError(address.refusal)
        identity = _identity(address)
        if address in self._libraries:
            known, opened = self._libraries[address]
            if known == identity and self._is_current(address, opened, look=look):
                return opened
        # With other folders or another token it is opened again, and the earlier one is of no use.
        for other in [other for other in self._libraries if other.place == address.place]:
            self._libraries.pop(other)[1].close()
        self._libraries[address] = identity, address.open()
        self._asked[address] = time.monotonic()
        return self._libraries[address][1]

    def _is_current(self, address: LibraryAddress, opened: SearchableLibrary, *, look: bool) -> bool:
        """Ask a service every now and then whether it has another library or version now."""
        if not isinstance(opened, ServiceLibrary):
            return True
        if not look and time.monotonic() - self._asked[address] < _SECONDS_BETWEEN_LOOKS:
            return True
        self._asked[address] = time.monotonic()
        return opened.is_current()

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


def as_address(library: LibraryAddress | Place) -> LibraryAddress:
    """Return the address of a library that is named by its place alone."""
    return library if isinstance(library, LibraryAddress) else LibraryAddress(library)


def _identity(address: LibraryAddress) -> tuple[int, int]:
    """Return the device and number of a file, which tell it from another one in its place."""
    path = address.place
    if not isinstance(path, Path) or not path.exists():
        return 0, 0
    status = path.stat()
    return status.st_dev, status.st_ino
