# SPDX-License-Identifier: MIT
"""Bringing a library of an earlier version up to date, after a backup."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from shapegoogle_core.api.arguments import as_path
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.parts.folders import PathLike
from shapegoogle_core.library.storage.address import as_place
from shapegoogle_core.library.storage.opening import connect
from shapegoogle_core.library.storage.sqlite.store import SqliteStore
from shapegoogle_core.model import ShapeModel

__all__ = ["UpgradeReport", "upgrade_library"]


@dataclass(frozen=True)
class UpgradeReport:
    """Outcome of upgrading a library.

    Attributes
    ----------
    upgraded : bool
        False if it was up to date.
    backup : Path or None
        File with the library as it was.
    format : int
        Version of the format afterwards.

    Examples
    --------
    A library that is new needs no upgrade:

    >>> import tempfile
    >>> import shapegoogle_core as sg
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with sg.Library.open(f"{folder}/shapes.sglib"):
    ...         pass
    ...     report = sg.upgrade_library(f"{folder}/shapes.sglib")
    >>> report.upgraded
    False
    """

    upgraded: bool
    backup: Path | None
    format: int


def upgrade_library(
    place: PathLike, backup: PathLike | None = None, *, make_backup: bool = True, timeout: float = 30.0
) -> UpgradeReport:
    """Upgrade a library that an earlier version of Shape Google has made, after writing a backup.

    Parameters
    ----------
    place : str or path-like
        The file, or the address of a database, see `Library.open`.
    backup : str or path-like, optional
        File for the backup, which must not exist: a copy of the file, or the result of `pg_dump`. By default
        beside the file, or in the working directory.
    make_backup : bool, optional
        False if there is a backup already.
    timeout : float, optional
        Longest time to wait while another program writes, in seconds.

    Returns
    -------
    report : UpgradeReport

    Raises
    ------
    LibraryError
        If there is no library, it is of a newer version or too old, or the backup fails; then nothing is
        changed.

    Examples
    --------
    >>> import tempfile
    >>> import shapegoogle_core as sg
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sg.Library.open(f"{folder}/shapes.sglib").close()
    ...     sg.upgrade_library(f"{folder}/shapes.sglib").upgraded
    False
    """
    library = as_place(place)
    file = None if backup is None else as_path(backup)
    if isinstance(library, Path):
        return _upgrade_file(library, file, make_backup=make_backup, timeout=timeout)
    return _upgrade_database(library, file, make_backup=make_backup, timeout=timeout)


def _upgrade_file(path: Path, backup: Path | None, *, make_backup: bool, timeout: float) -> UpgradeReport:
    if not path.is_file():
        raise LibraryError(f"there is no library '{path}'; check the name")
    with closing(SqliteStore(path, create=False, read_only=False, timeout=timeout)) as store:
        store.check_format()
        before = store.summary().format
        if store.has_kind_tables():
            return UpgradeReport(False, None, before)
        copy = backup or path.with_name(f"{path.name}.format-{before}")
        if make_backup:
            store.copy_file(copy)
        with store.writing():
            pass  # the first change adds the tables
        return UpgradeReport(True, copy if make_backup else None, store.summary().format)


def _upgrade_database(url: str, backup: Path | None, *, make_backup: bool, timeout: float) -> UpgradeReport:
    with closing(connect(url, read_only=False, timeout=timeout)) as store:
        from shapegoogle_core.library.storage.postgresql.administration import (
            back_up,
            is_outdated,
            upgrade_tables,
        )

        if store.is_empty():
            raise LibraryError(f"there is no library in '{store.name}'; check the address")
        if not is_outdated(store):
            return UpgradeReport(False, None, store.summary().format)
        version = store.summary().format
        database = store.connection.info.dbname.replace("/", "_")
        file = backup or Path(f"{database}.{store.address.schema}.format-{version}.dump")
        if make_backup:
            back_up(store, file)
        upgrade_tables(store, ShapeModel.from_bytes(store.model()[1], origin=f"the model in '{store.name}'"))
        return UpgradeReport(True, file if make_backup else None, store.summary().format)
