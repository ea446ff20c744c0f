# SPDX-License-Identifier: MIT
"""The indexing run: bring a library up to date with files, opening only those that are new or changed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from shapegoogle_core.api.arguments import as_paths
from shapegoogle_core.indexing.progress.events import FileOutcome, IndexingProgress, IndexReport
from shapegoogle_core.indexing.progress.remaining import working_order
from shapegoogle_core.indexing.progress.tracking import ProgressTracker
from shapegoogle_core.indexing.reading.describing import ReadFunction
from shapegoogle_core.indexing.reading.external_reader import ExternalReader
from shapegoogle_core.indexing.reading.file_pool import FilePool
from shapegoogle_core.indexing.reading.notes import total_left_out
from shapegoogle_core.indexing.reading.shape_reader import ShapeReader
from shapegoogle_core.indexing.run import IndexingRun
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import SourceRecord
from shapegoogle_core.processes.launching import default_jobs

__all__ = ["index_files", "index_known_files"]

# Number of submitted files per process: enough to keep all of them busy, few enough to keep memory flat.
FILES_AHEAD = 3


def index_files(
    library: Library,
    paths: str | Path | Iterable[str | Path],
    settings: IndexSettings | None = None,
    *,
    progress: Callable[[FileOutcome], None] | None = None,
    status: Callable[[IndexingProgress], None] | None = None,
    reader: ExternalReader | None = None,
    read: ReadFunction | None = None,
) -> IndexReport:
    """Bring a library up to date with mesh files.

    A file of known size and time is not opened; a file of known content is not described again, even under
    another name, unless the reader's options have changed or an earlier version of Shape Google described it
    without views. All others are described by worker processes and
    stored one by one, each in a transaction: whatever ends the run, files already stored are kept. If a file
    fails whose content gave shapes before, these shapes are kept. In a script, call it under
    ``if __name__ == "__main__":``, since it starts processes.

    Parameters
    ----------
    library : Library
        Open for writing.
    paths : str, Path, or iterable of them
        Mesh files, such as those listed by `find_meshes`.
    settings : IndexSettings, optional
        Number of processes, time and memory limits, and which files are read again.
    progress : callable, optional
        Called with the `FileOutcome` of each file.
    status : callable, optional
        Called with an `IndexingProgress` several times in a second, if there is something new.
    reader : ExternalReader, optional
        Another program for files that this package does not read. The limits of the settings hold for it
        too.
    read : callable, optional
        How the processes read a file, for tests: a function of a `ShapeReader` and a path that can be
        imported by its name. `ShapeReader.iterate` by default.

    Returns
    -------
    report : IndexReport

    Raises
    ------
    ValueError
        If a path is neither a str nor a path.
    LibraryError
        If the library cannot be written.
    ShapeGoogleError
        If the worker processes cannot be started.

    See Also
    --------
    find_meshes : lists the mesh files of folders.
    Library.add : adds a single mesh.

    Examples
    --------
    Files that cannot be read are reported, and the others are indexed:

    >>> import tempfile
    >>> from pathlib import Path
    >>> import shapegoogle_core as sg
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with sg.Library.open(Path(folder, "animals.sglib")) as library:
    ...         report = sg.index_files(library, [Path(folder, "horse.ply")], sg.IndexSettings(jobs=2))
    >>> report.added
    0
    >>> [path.name for path, reason in report.failed]
    ['horse.ply']
    """
    listed = as_paths(paths)
    library.add_roots(listed)
    tracker = ProgressTracker(status)
    settings = settings or IndexSettings()
    report = _index(
        library, listed, settings, IndexingRun(library, settings, reader, progress, tracker), read
    )
    # Of shapes that an interrupted run or an older program has added, or whose neighbours are gone.
    library.update_neighbours()
    tracker.report(always=True)
    return report


def index_known_files(
    library: Library,
    paths: Iterable[str],
    settings: IndexSettings,
    known: Mapping[str, SourceRecord],
    *,
    progress: Callable[[FileOutcome], None] | None = None,
    reader: ExternalReader | None = None,
) -> IndexReport:
    """Index a part of the files of a run that others share, without reading the whole library.

    Copies of files are described again, and `Library.update_neighbours` is left to the end of the whole run.

    Parameters
    ----------
    library : Library
        Open for writing.
    paths : iterable of str
        Below roots of the library.
    settings : IndexSettings
    known : mapping of str to SourceRecord
        What the library knows about these files, by path.
    progress : callable, optional
        Called with the `FileOutcome` of each file.
    reader : ExternalReader, optional
        See `index_files`.

    Returns
    -------
    report : IndexReport
    """
    run = IndexingRun(library, settings, reader, progress, ProgressTracker(None), known)
    with library.neighbours_later():
        return _index(library, list(map(Path, paths)), settings, run, None)


def _index(
    library: Library,
    listed: Sequence[Path],
    settings: IndexSettings,
    run: IndexingRun,
    read: ReadFunction | None,
) -> IndexReport:
    """Index files below roots of the library."""
    started, tracker, reader = time.monotonic(), run.tracker, run.reader
    changed = run.pass_over_unchanged(map(Path, library.source_paths(listed)))
    jobs = settings.jobs or default_jobs()
    several_shapes = frozenset() if reader is None else reader.suffixes
    # A mesh file is one shape; a file that another program reads may contain thousands.
    if reader is None or not any(reader.reads(path) for path in changed):
        jobs = min(jobs, max(len(changed), 1))
    tracker.start(run.sizes, changed, jobs, several_shapes)
    read = read or ShapeReader.iterate
    with FilePool(library.model, _limited(reader, settings), read, jobs, settings, tracker) as pool:
        samples, others = working_order([(path, run.sizes[path]) for path in changed], several_shapes)
        for path, _ in samples:
            run.begin(path, pool, first=True)
        for path, _ in others:
            run.begin(path, pool)
            while len(pool) >= FILES_AHEAD * jobs:
                run.store_finished(pool)
        while len(pool):
            run.store_finished(pool)
            # The meshes of linked files are shapes of those files.
            for path in run.take_linked():
                run.begin(path, pool)
    return IndexReport(
        added=run.counts["added"],
        updated=run.counts["updated"],
        unchanged=run.counts["unchanged"],
        shapes=run.shapes,
        failed=run.failed,
        seconds=time.monotonic() - started,
        updated_shapes=run.updated_shapes,
        partial_shapes=run.partial_shapes,
        warnings=run.warnings,
        left_out=total_left_out(run.left_out),
    )


def _limited(reader: ExternalReader | None, settings: IndexSettings) -> ExternalReader | None:
    """Apply the limits of a run to a reader that has none, or larger ones."""
    if reader is None:
        return None
    return replace(
        reader,
        time_limit=min(reader.time_limit or settings.time_limit, settings.time_limit),
        memory_limit=settings.memory_limit if reader.memory_limit is None else reader.memory_limit,
    )
