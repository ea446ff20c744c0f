# SPDX-License-Identifier: MIT
"""Indexed files that are no longer there."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.records import SourceRecord

__all__ = ["missing_files"]


def missing_files(sources: Iterable[SourceRecord], folders: Iterable[str | os.PathLike[str]]) -> list[str]:
    """List the sources below folders that are no longer there.

    Parameters
    ----------
    sources : iterable of SourceRecord
    folders : iterable of str or path-like
        See `Library.remove_missing`.

    Returns
    -------
    missing : list of str
        Paths of the sources.

    Raises
    ------
    LibraryError
        If a folder does not exist.
    """
    roots = [Path(folder).resolve() for folder in folders]
    for root in roots:
        if not root.is_dir():
            raise LibraryError(
                f"'{root}' is not there, so files missing from it were kept; plug in its drive, or name "
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
    """Whether a file is certainly not there; one that cannot be reached may be."""
    try:
        Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        return True
    except OSError:
        return False
    return False
