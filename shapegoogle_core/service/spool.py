# SPDX-License-Identifier: MIT
"""A folder of uploads and results that all processes of a service share, each under a name nobody guesses."""

from __future__ import annotations

import os
import re
import secrets
import time
from pathlib import Path

from shapegoogle_core.service.settings import ServiceError

__all__ = ["Spool"]

_NAME = re.compile(r"[A-Za-z0-9_-]{24}")
_PART = re.compile(r"[a-z0-9.]{1,20}")
# Seconds that an upload or a result is kept after it was last used, and the room that all take at most.
_KEPT, _MOST_BYTES = 2 * 3600.0, 2**30
_SWEEP_SECONDS = 60.0


class Spool:
    """Files under random names; old ones are removed.

    Parameters
    ----------
    folder : Path
        Exists.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._next_sweep = 0.0

    def new_name(self) -> str:
        """Make up a name that nobody guesses, and that no other process makes up."""
        return secrets.token_urlsafe(18)

    def put(self, name: str, part: str, content: bytes) -> None:
        """Store a file, in place of an earlier one as a whole.

        Parameters
        ----------
        name : str
            From `new_name`.
        part : str
            What the file is, such as "query.json".
        content : bytes
        """
        self._sweep()
        path = self._path(name, part)
        draft = self._folder / f"draft-{secrets.token_hex(8)}"
        draft.write_bytes(content)
        draft.replace(path)

    def get(self, name: str, part: str) -> bytes:
        """Read a file.

        Parameters
        ----------
        name : str
            As a client sent it.
        part : str

        Returns
        -------
        content : bytes

        Raises
        ------
        ServiceError
            404 if there is none.
        """
        gone = ServiceError(404, "this upload or search is not known any more; upload or search again")
        if not _NAME.fullmatch(name):
            raise gone
        path = self._path(name, part)
        try:
            os.utime(path)
            return path.read_bytes()
        except FileNotFoundError as error:
            raise gone from error

    def _path(self, name: str, part: str) -> Path:
        if not (_NAME.fullmatch(name) and _PART.fullmatch(part)):
            raise ValueError(f"no file of the spool has the name {name!r} and the part {part!r}")
        return self._folder / f"{name}.{part}"

    def _sweep(self) -> None:
        """Remove what is old, and the oldest of what takes too much room."""
        now = time.time()
        if now < self._next_sweep:
            return
        self._next_sweep = now + _SWEEP_SECONDS
        files = []
        for entry in os.scandir(self._folder):
            try:
                status = entry.stat()
            except FileNotFoundError:  # another process removed it
                continue
            if entry.is_file() and _NAME.match(entry.name):
                files.append((status.st_mtime, status.st_size, Path(entry.path)))
        room = sum(size for _, size, _ in files)
        for used, size, path in sorted(files):
            if now - used <= _KEPT and room <= _MOST_BYTES:
                break
            path.unlink(missing_ok=True)
            room -= size
