# SPDX-License-Identifier: MIT
"""Search for indexed files that no longer exist."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.records import SourceRecord

__all__ = ["missing_files"]


def missing_files(sources: Iterable[SourceRecord], folders: Iterable[str | os.PathLike[str]]) -> list[str]:
    """List the indexed files below some folders that no longer exist.

    Parameters
    ----------
    sources : iterable of SourceRecord
    folders : iterable of str or path-like
        Each must exist: on a drive that is not plugged in all files are missing.

    Returns
    -------
    missing : list of str
        Their paths.

    Raises
    ------
    LibraryError
        If a folder does not exist.
    """
    roots = [Path(folder).resolve() for folder in folders]
    for root in roots:
        if not root.is_dir():
            raise LibraryError(
                f"'{root}' does not exist, so its files stay in the library; plug in its drive, or name "
                "another folder"
            )
    return [
        source.path
        for source in sources
        # Only indexed files have a size; other sources are names that need not be paths.
        if source.size is not None
        and any(Path(source.path).resolve().is_relative_to(root) for root in roots)
        and _is_gone(source.path)
    ]


def _is_gone(path: str) -> bool:
    """Return whether a file certainly does not exist; one that cannot be reached may exist."""
    try:
        Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        return True
    except OSError:
        return False
    return False
