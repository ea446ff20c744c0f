# SPDX-License-Identifier: MIT
"""Copying whole libraries between files and databases."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.parts.folders import PathLike
from shapegoogle_core.library.storage.address import as_place, shown_place
from shapegoogle_core.library.storage.copying import CopyReport, copy_stored
from shapegoogle_core.library.storage.opening import open_store

__all__ = ["CopyReport", "copy_library"]


def copy_library(
    source: PathLike,
    target: PathLike,
    progress: Callable[[Sequence[int]], Iterable[int]] = iter,
    *,
    timeout: float = 30.0,
) -> CopyReport:
    """Copy a library to a new place: a file, or a PostgreSQL database.

    Shapes keep their numbers. An interrupted copy goes on when it is started again.

    Parameters
    ----------
    source, target : str or path-like
        Paths of files or addresses of databases, see `Library.open`. The target is new, or an unfinished copy
        of the same library.
    progress : callable, optional
        Wraps the loop over the shapes that are missing, as tqdm does.
    timeout : float, optional
        Longest time to wait while another program writes, in seconds.

    Returns
    -------
    report : CopyReport

    Raises
    ------
    LibraryError
        If the target is a library in use, or a copy of another one; if either cannot be read or written.

    Examples
    --------
    >>> import tempfile, trimesh
    >>> import shapegoogle_core as sg
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
    ...         _ = library.add(trimesh.creation.box(), name="box")
    ...     report = sg.copy_library(f"{folder}/shapes.sglib", f"{folder}/copy.sglib")
    >>> report.copied, report.shapes
    (1, 1)
    """
    if shown_place(as_place(source)) == shown_place(as_place(target)):
        raise LibraryError(f"'{shown_place(source)}' cannot be copied onto itself; name another place")
    read, model = open_store(as_place(source), None, read_only=True, timeout=timeout)
    with closing(read):
        written, _ = open_store(as_place(target), model, read_only=False, timeout=timeout, unfinished=True)
        with closing(written):
            return copy_stored(read, written, model, progress)
