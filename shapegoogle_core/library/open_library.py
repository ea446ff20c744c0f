# SPDX-License-Identifier: MIT
"""Opening and closing a library; its file and its model."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType
from typing import Self

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.storage.opening import open_store
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel

__all__ = ["OpenLibrary", "PathLike"]

PathLike = str | os.PathLike[str]


class OpenLibrary:
    """An open library file with the model that described its shapes; the base of `Library`.

    Parameters
    ----------
    store : Store
        The open file.
    model : ShapeModel
        The model of the library.
    search : SearchSettings, optional
        Settings of all searches; the default values if left out.
    """

    def __init__(self, store: Store, model: ShapeModel, search: SearchSettings | None = None) -> None:
        self._store = store
        self._model = model
        self._settings = SearchSettings() if search is None else search

    @classmethod
    def open(
        cls,
        path: PathLike,
        model: ShapeModel | None = None,
        *,
        read_only: bool = False,
        timeout: float = 30.0,
        search: SearchSettings | None = None,
    ) -> Self:
        """Open a library, or make a new one.

        Parameters
        ----------
        path : str or path-like
            The file. An existing library on a write-protected disk can be opened too, for searching only.
        model : ShapeModel, optional
            For a new library, the model that describes its shapes; by default the one that ships with the
            package. For an existing library, its own model, which is also the default.
        read_only : bool, optional
            Never change the file, and make none.
        timeout : float, optional
            Longest time to wait while another program writes, in seconds.
        search : SearchSettings, optional
            Settings of all searches; the default values if left out.

        Returns
        -------
        library : Library
            Also a context manager that closes it.

        Raises
        ------
        LibraryError
            If the path is a folder, lies in no folder or is no library; if the library is damaged, made by
            another version or with another model; if there is none and it may not or cannot be made.
        ModelError
            If a new library is to be made and the shipped model cannot be loaded.

        Examples
        --------
        >>> import tempfile
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         len(library)
        0
        """
        return cls(*open_store(Path(path), model, read_only=read_only, timeout=timeout), search)

    def close(self) -> None:
        """Close the file. Closing twice does no harm."""
        self._store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self.path}', model {self._model.identifier})"

    @property
    def path(self) -> Path:
        """The file."""
        return Path(self._store.name)

    @property
    def model(self) -> ShapeModel:
        """The model that describes the shapes of this library."""
        return self._model

    @property
    def read_only(self) -> bool:
        """Whether changes are refused: on request, or because the file is write-protected."""
        return self._store.read_only

    def _unknown(self, shape_id: int) -> LibraryError:
        return LibraryError(
            f"'{self.path}' has no shape {shape_id}; it was removed or replaced: search again"
        )
