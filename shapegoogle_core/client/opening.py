# SPDX-License-Identifier: MIT
"""Opening libraries for searching, wherever they lie: `open_library` and `LibraryAddress`."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from shapegoogle_core.client.service_library import ServiceLibrary
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.searchable import SearchableLibrary
from shapegoogle_core.library.storage.address import (
    Place,
    as_place,
    is_database,
    is_service,
    shown_place,
    with_password,
)
from shapegoogle_core.library.storage.opening import check_exists

__all__ = ["TOKEN_VARIABLE", "LibraryAddress", "open_library", "token_from_environment"]

TOKEN_VARIABLE = "SHAPEGOOGLE_TOKEN"
"""Environment variable with the token of a service, where no other is given."""


@dataclass(frozen=True)
class LibraryAddress:
    """Where a library lies, and all that opening it needs.

    Attributes
    ----------
    place : Path or str
        File, or URL of a database or a service.
    roots : tuple of (str, str)
        Names of roots and the folders that they are on this computer. Those that the library does not have
        are left out.
    token : str
        Of a service.
    password : str
        Of a database, unless the address has one.
    certificate, cache : str
        See `ServiceLibrary.connect`.
    refusal : str
        Sentence that says why the library must not be opened; empty if it may.

    Examples
    --------
    >>> from pathlib import Path
    >>> from shapegoogle_core.client import LibraryAddress
    >>> LibraryAddress(Path("shapes.sglib")).name
    'shapes.sglib'
    """

    place: Place
    roots: tuple[tuple[str, str], ...] = ()
    token: str = field(default="", repr=False)
    password: str = field(default="", repr=False)
    certificate: str = ""
    cache: str = ""
    refusal: str = ""

    @property
    def name(self) -> str:
        """The place as messages name it."""
        return shown_place(self.place)

    @property
    def is_service(self) -> bool:
        """Whether it is that of a service."""
        return is_service(self.place)

    def open(self, *, read_only: bool = True, search: SearchSettings | None = None) -> SearchableLibrary:
        """Open the library.

        Parameters
        ----------
        read_only : bool, optional
            Whether a file or database is opened for reading; a service decides by the token.
        search : SearchSettings, optional
            Settings of all searches, in a file or database.

        Returns
        -------
        library : SearchableLibrary

        Raises
        ------
        LibraryError
            If it cannot or must not be opened; a library that does not exist is never made.
        """
        if self.refusal:
            raise LibraryError(self.refusal)
        opened: SearchableLibrary
        if self.is_service:
            opened = ServiceLibrary.connect(
                str(self.place),
                token=self.token,
                certificate=self.certificate,
                cache=Path(self.cache) if self.cache else None,
            )
        else:
            if not read_only:
                check_exists(self.place)
            place = with_password(str(self.place), self.password) if is_database(self.place) else self.place
            opened = Library.open(place, read_only=read_only, search=search)
        known = {root.name for root in opened.roots()} if self.roots else set()
        for name, folder in self.roots:
            if name in known:
                opened.map_root(name, folder)
        return opened


def token_from_environment() -> str:
    """Return the token in the environment variable SHAPEGOOGLE_TOKEN; empty without one."""
    return os.environ.get(TOKEN_VARIABLE, "")


def open_library(
    place: str | os.PathLike[str],
    *,
    roots: Mapping[str, str | os.PathLike[str]] | None = None,
    token: str | None = None,
    certificate: str = "",
    search: SearchSettings | None = None,
) -> SearchableLibrary:
    """Open a library to search it: a file, a database or a service.

    Parameters
    ----------
    place : str or path-like
        Path of the file, or URL: ``postgresql://host/name`` of a database, ``https://host`` of a service.
    roots : mapping of str to path, optional
        Folders of this computer by the names of the library's roots that they are, see `Library.map_root`.
    token : str, optional
        Of a service; by default that in the environment variable SHAPEGOOGLE_TOKEN.
    certificate : str, optional
        See `ServiceLibrary.connect`.
    search : SearchSettings, optional
        Settings of all searches; not with a service, which has its own.

    Returns
    -------
    library : SearchableLibrary
        A `Library` that is open for reading, or a `ServiceLibrary`. Also a context manager that closes it.

    Raises
    ------
    LibraryError
        If there is no such library, it cannot be reached, or it has no such root.

    Examples
    --------
    >>> import tempfile, trimesh
    >>> import shapegoogle_core as sg
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
    ...         _ = library.add(trimesh.creation.box(), name="box")
    ...     with sg.open_library(f"{folder}/shapes.sglib") as library:
    ...         [match.name for match in library.query(trimesh.creation.box())]
    ['box']
    """
    if is_service(place) and search not in (None, SearchSettings()):
        raise LibraryError(f"'{place}' searches with settings of its own; leave yours out")
    token = token_from_environment() if token is None else token
    library = LibraryAddress(as_place(place), token=token, certificate=certificate).open(search=search)
    try:
        for name, folder in (roots or {}).items():
            library.map_root(name, folder)
    except BaseException:
        library.close()
        raise
    return library
