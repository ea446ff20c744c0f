# SPDX-License-Identifier: MIT
"""What an indexing run would do, without doing it."""

from __future__ import annotations

from collections.abc import Container, Iterable
from pathlib import Path

from shapegoogle_core.indexing.files import absolute, choices_of, examine, stamp, unreadable
from shapegoogle_core.indexing.progress.events import FileOutcome
from shapegoogle_core.indexing.reading.external_reader import ExternalReader
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import SourceRecord

__all__ = ["failed_before", "is_read_again", "plan_indexing"]


def plan_indexing(
    library: Library | None,
    paths: Iterable[Path],
    settings: IndexSettings | None = None,
    reader: ExternalReader | None = None,
) -> list[FileOutcome]:
    """Say what `index_files` would do with each file; no mesh is read and nothing is changed.

    Parameters
    ----------
    library : Library or None
        May be open for reading only; None if it would be created.
    paths : iterable of Path
    settings : IndexSettings, optional
    reader : ExternalReader, optional

    Returns
    -------
    outcomes : list of FileOutcome
        "added" and "updated" for files that would be read, "unchanged" for those that would not, "failed" for
        those that cannot be opened, or failed before and have not changed.
    """
    settings = settings or IndexSettings()
    listed = list(paths)
    known = {} if library is None else library.sources()
    lacking = frozenset() if library is None else library.sources_without_views()
    named = map(absolute, listed) if library is None else map(Path, library.source_paths(listed))
    return [_outcome(path, known.get(str(path)), lacking, settings, reader) for path in dict.fromkeys(named)]


def is_read_again(
    source: SourceRecord, lacking: Container[str], settings: IndexSettings, reader: ExternalReader | None
) -> bool:
    """Whether a file is read again though it has not changed.

    Parameters
    ----------
    source : SourceRecord
    lacking : container of str
        Paths of sources that an earlier version has described without views.
    settings : IndexSettings
    reader : ExternalReader or None

    Returns
    -------
    again : bool
    """
    if settings.reread or (settings.retry and source.error is not None):
        return True
    if source.path in lacking and source.error is None:
        return True
    choices = "" if reader is None else reader.choices_for(Path(source.path))
    return source.sha256 is not None and choices_of(source.sha256) != choices


def failed_before(source: SourceRecord) -> str:
    """Write the reason why a file that has not changed is not tried again.

    Parameters
    ----------
    source : SourceRecord
        With an error.

    Returns
    -------
    reason : str
    """
    return f"{source.error} (found in an earlier run; --retry tries it again)"


def _outcome(
    path: Path,
    source: SourceRecord | None,
    lacking: Container[str],
    settings: IndexSettings,
    reader: ExternalReader | None,
) -> FileOutcome:
    try:
        size, mtime_ns = stamp(path)
        if source is not None and not is_read_again(source, lacking, settings, reader):
            same = (source.size, source.mtime_ns) == (size, mtime_ns)
            if not same and source.size == size:  # possibly only touched, or copied to its place again
                choices = "" if reader is None else reader.choices_for(path)
                same = examine(path, choices).sha256 == source.sha256
            if same and source.error is not None:
                return FileOutcome(path, "failed", failed_before(source))
            if same:
                return FileOutcome(path, "unchanged")
    except OSError as error:
        return FileOutcome(path, "failed", unreadable(path, error))
    return FileOutcome(path, "updated" if source is not None and source.shape_count else "added")
