# SPDX-License-Identifier: MIT
"""Folders for temporary files, and removing those of programs that were killed.

A folder contains a file that its owner keeps locked. The system releases the lock when the owner ends,
however it ends; a process that has got the number of a dead one by chance is not taken for it, as it would be
if numbers were written down. The file also names the machine, since locks of another one may not be visible
where several share a folder for temporary files.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

__all__ = ["VARIABLES", "locked", "remove_abandoned_folders", "temporary_folder"]

VARIABLES = ("TMPDIR", "TEMP", "TMP")
"""Environment variables for the folder of temporary files; which of them counts depends on the system."""

PREFIX = "shapegoogle-"
OWNER = "owner"
# What `tempfile` appends, and nothing else.
_NAME = re.compile(re.escape(PREFIX) + r"[a-z0-9_]{8}")
# First line of the file, so that no other folder with such a name is removed.
_TITLE = "temporary files of Shape Google on "
# Offset of the locked byte: on Windows nobody can read what is locked.
_LOCKED_BYTE = 2**20


@contextmanager
def temporary_folder(within: Path | None = None) -> Iterator[Path]:
    """Create a folder for temporary files, and remove it at the end of the block.

    If this process is killed, the next program that uses such a folder removes it.

    Parameters
    ----------
    within : Path, optional
        Existing folder to create it in; by default the system's folder for temporary files.

    Yields
    ------
    folder : Path

    Examples
    --------
    >>> from shapegoogle_core.processes.temporary import temporary_folder
    >>> with temporary_folder() as folder:
    ...     folder.is_dir()
    True
    >>> folder.exists()
    False
    """
    remove_abandoned_folders()
    # A process that is killed may still be writing there when the folder is removed.
    with tempfile.TemporaryDirectory(prefix=PREFIX, dir=within, ignore_cleanup_errors=True) as name:
        folder = Path(name)
        descriptor = os.open(folder / OWNER, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            # Where locks do not work, the file stays empty, and the folder is never taken for abandoned.
            with suppress(OSError):
                _lock(descriptor, wait=True)
                os.write(descriptor, f"{_TITLE}{platform.node()}\n".encode())
            yield folder
        finally:
            # Before the folder is removed: Windows removes no file that is open.
            os.close(descriptor)


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Lock a file during the block; other programs that want the same wait.

    Where locks do not work, as on some network drives, the block runs without one.

    Parameters
    ----------
    path : Path
        Made if it is missing; it stays, since another program may be waiting for it.

    Raises
    ------
    OSError
        If the file cannot be made or opened.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from shapegoogle_core.processes.temporary import locked
    >>> with tempfile.TemporaryDirectory() as folder, locked(Path(folder, "tokens.lock")):
    ...     pass
    """
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        with suppress(OSError):
            _lock(descriptor, wait=True)
        yield
    finally:
        os.close(descriptor)


def remove_abandoned_folders() -> list[Path]:
    """Remove the folders of `temporary_folder` whose owners have ended without doing so.

    Folders of other users and machines, and other folders with such names, are left alone.

    Returns
    -------
    removed : list of Path
    """
    removed = []
    try:
        entries = list(os.scandir(tempfile.gettempdir()))
    except OSError:  # whoever needs the folder reports it
        return []
    for entry in entries:
        if _NAME.fullmatch(entry.name) and _remove_if_abandoned(Path(entry.path)):
            removed.append(Path(entry.path))
    return removed


def _remove_if_abandoned(folder: Path) -> bool:
    try:
        status = folder.lstat()
        # A link could lead anywhere.
        if not stat.S_ISDIR(status.st_mode) or (sys.platform != "win32" and status.st_uid != os.geteuid()):
            return False
        flags = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
        descriptor = os.open(folder / OWNER, flags)
    except OSError:  # no such file, not this user's, or removed meanwhile
        return False
    try:
        _lock(descriptor, wait=False)
        title = os.read(descriptor, 1000).decode("utf-8", "replace").strip()
    except OSError:  # its owner lives
        return False
    finally:
        os.close(descriptor)
    if title != f"{_TITLE}{platform.node()}":
        return False
    shutil.rmtree(folder, ignore_errors=True)
    return not folder.exists()


def _lock(descriptor: int, *, wait: bool) -> None:
    """Lock a file as long as it is open; raises OSError if another process has locked it."""
    if sys.platform == "win32":
        import msvcrt

        os.lseek(descriptor, _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)
    else:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
