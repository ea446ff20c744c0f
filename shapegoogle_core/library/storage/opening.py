# SPDX-License-Identifier: MIT
"""Opening and making libraries in files and databases; refusal of unsuitable ones and of models."""

from __future__ import annotations

import stat
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shapegoogle_core.errors import LibraryError, ModelError
from shapegoogle_core.library.storage.address import Place, as_place, is_service, shown_place
from shapegoogle_core.library.storage.sqlite.store import SqliteStore
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.loading import SHIPPED, as_model
from shapegoogle_core.model.model_file import views_identifier

if TYPE_CHECKING:
    from shapegoogle_core.library.storage.postgresql.store import PostgresqlStore

__all__ = ["check_exists", "connect", "library_exists", "open_store"]


def open_store(
    place: Place,
    model: ShapeModel | str | Path | None,
    *,
    read_only: bool,
    timeout: float,
    unfinished: bool = False,
) -> tuple[Store, ShapeModel]:
    """Open a library, or make a new one.

    Parameters
    ----------
    place, model, read_only, timeout
        See `Library.open`.
    unfinished : bool, optional
        Accept an unfinished copy of another library for writing.

    Returns
    -------
    store : Store
    model : ShapeModel
        The model that describes its shapes.

    Raises
    ------
    LibraryError, ModelError
        See `Library.open`.
    """
    store: SqliteStore | PostgresqlStore
    _refuse_service(place)
    if isinstance(place, Path):
        exists = _is_file(place)
        if not exists:
            _check_place(place, read_only=read_only)
        # Before the file is created: a missing model must not leave one behind.
        given = None if model is None and exists else as_model(model)
        store = SqliteStore(place, create=not exists, read_only=read_only, timeout=timeout)
    else:
        given = None if model is None else as_model(model)
        store = connect(place, read_only=read_only, timeout=timeout)
    try:
        if store.is_empty():
            if read_only:
                raise LibraryError("'{name}' is empty; index a folder into it first", name=store.name)
            given = given or as_model(None)
            store.initialise(given)
        store.check_format()
        if not (read_only or unfinished) and (mark := store.copy_mark()) is not None:
            raise LibraryError(
                f"'{store.name}' is an unfinished copy of '{mark}'; complete it with `shapegoogle copy` first"
            )
        return store, _matching_model(store, given, read_only=store.read_only)
    except BaseException:
        store.close()
        raise


def connect(url: str, *, read_only: bool, timeout: float) -> PostgresqlStore:
    """Connect to a database, which need not hold a library yet.

    Parameters
    ----------
    url : str
        See `Library.open`.
    read_only : bool
    timeout : float
        Longest time to wait for another program's lock, in seconds.

    Returns
    -------
    store : PostgresqlStore

    Raises
    ------
    LibraryError
        If it cannot be reached, or the package that connects is not installed.
    """
    if find_spec("psycopg") is None:
        raise LibraryError(
            "a library in a database needs the package psycopg; install it with: "
            'pip install "shapegoogle-core[postgresql]"'
        )
    from shapegoogle_core.library.storage.postgresql.address import parse_address
    from shapegoogle_core.library.storage.postgresql.store import PostgresqlStore

    return PostgresqlStore(parse_address(url), read_only=read_only, timeout=timeout)


def library_exists(place: Place) -> bool:
    """Whether there is a library at a place, or something else that opening it would explain.

    Parameters
    ----------
    place : Path or str

    Returns
    -------
    exists : bool

    Raises
    ------
    LibraryError
        If a database cannot be reached.
    """
    place = as_place(place)
    _refuse_service(place)
    if isinstance(place, Path):
        return place.exists()
    store = connect(place, read_only=True, timeout=30.0)
    try:
        return not store.is_empty()
    finally:
        store.close()


def check_exists(place: Place) -> None:
    """Refuse a place without a library, where opening it for writing would make a new one.

    Parameters
    ----------
    place : Path or str

    Raises
    ------
    LibraryError
        If there is no library, or a database cannot be reached.
    """
    if not (_is_file(place) if isinstance(place, Path) else library_exists(place)):
        raise LibraryError(
            "there is no library '{place}'; check the name, or index a folder into it first",
            place=shown_place(place),
        )


def _is_file(path: Path) -> bool:
    """Return whether there is a file at a path; a folder or an unreachable path is an error."""
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise LibraryError(
            "'{path}' cannot be reached: {reason}; choose another place", path=path, reason=error.strerror
        ) from error
    except ValueError as error:
        raise LibraryError(f"{str(path)!r} has a null character in its name; choose another name") from error
    if stat.S_ISDIR(mode):
        raise LibraryError(
            "'{path}' is a folder; a library is one file: name a file in it, such as 'shapes.sglib'",
            path=path,
        )
    return True


def _refuse_service(place: Place) -> None:
    """Refuse the address of a service where the file or the database itself is needed."""
    if is_service(place):
        raise LibraryError(
            f"'{place}' is a service, which others can search and decide in; for all else name the library "
            "that it serves, on the machine where it runs"
        )


def _check_place(path: Path, *, read_only: bool) -> None:
    """Make sure that a new library may be made at a path."""
    if read_only:
        raise LibraryError(
            "there is no library '{place}'; check the name, or index a folder into it first", place=path
        )
    if not path.parent.is_dir():
        raise LibraryError(
            "'{path}' cannot be created: there is no folder '{folder}'; create it first",
            path=path,
            folder=path.parent,
        )


def _matching_model(store: Store, given: ShapeModel | None, *, read_only: bool) -> ShapeModel:
    """Return the library's own model, completed by the parts that an earlier version did not know."""
    identifier, content = store.model()
    if given is not None:
        _check_identifier(store, identifier, given)
        if views_identifier(content) == (None if given.views is None else given.views.identifier):
            return given
    try:
        model = ShapeModel.from_bytes(content, origin=f"the model in '{store.name}'")
    except ModelError as error:
        raise LibraryError("{reason}", reason=error) from error
    _check_identifier(store, identifier, model)
    if None not in _parts(model).values():
        return model
    later = as_model(model.name) if given is None and model.name in SHIPPED else given
    if later is None or later.identifier != identifier:
        return model
    gained = {name: part for name, part in _parts(later).items() if _parts(model)[name] is None}
    complete = model.with_parts(**gained)
    if any(part is not None for part in gained.values()) and not read_only:
        store.extend_model(identifier, complete.to_bytes())
    return complete


def _parts(model: ShapeModel) -> dict[str, Any]:
    """Return the parts of a model that say nothing about bags."""
    return {"views": model.views, "background": model.background, "ranking": model.ranking}


def _check_identifier(store: Store, identifier: str, model: ShapeModel) -> None:
    if model.identifier != identifier:
        raise LibraryError(
            f"'{store.name}' was made with model {identifier}, not with {model.identifier} ({model.name}): "
            "their signatures cannot be compared; leave the model out to use the library's own, or index "
            "your folders into a new library"
        )
