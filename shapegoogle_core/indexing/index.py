# SPDX-License-Identifier: MIT
"""From folders of files to a library, touching only what is new or changed."""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Literal, Protocol

from shapegoogle_core.indexing.files import (
    ContentKey,
    FileState,
    absolute,
    choices_of,
    content_key,
    content_of,
    examine,
    stamp,
)
from shapegoogle_core.indexing.readers import ExternalReader, FoundShape, iterate_shapes
from shapegoogle_core.indexing.tasks import DescribedShape, Failure
from shapegoogle_core.indexing.workers import DescribedFile, Workers, default_jobs
from shapegoogle_core.library import Library, NewShape, SourceRecord
from shapegoogle_core.processes.launching import single_threaded

__all__ = ["FileOutcome", "IndexReport", "index_files"]

# Files in the hands of the workers, for each of them: enough that none waits, few enough to keep memory flat.
AHEAD = 3


@dataclass(frozen=True)
class FileOutcome:
    """What became of one file.

    Attributes
    ----------
    path : Path
        Absolute.
    status : str
        "added", "updated" (its content changed), "unchanged" or "failed".
    reason : str
        Why it failed, else empty.
    details : str
        The traceback of an error nobody foresaw, else empty.
    """

    path: Path
    status: Literal["added", "updated", "unchanged", "failed"]
    reason: str = ""
    details: str = ""


@dataclass(frozen=True)
class IndexReport:
    """What a run of `index_files` did.

    Attributes
    ----------
    added, updated, unchanged : int
        Numbers of files.
    shapes : int
        How many shapes the added and updated files gave.
    failed : list of (Path, str)
        Each file that is not in the library, and why.
    seconds : float
        How long it took.
    """

    added: int
    updated: int
    unchanged: int
    shapes: int
    failed: list[tuple[Path, str]]
    seconds: float


def index_files(
    library: Library,
    paths: Sequence[str | Path],
    *,
    jobs: int | None = None,
    time_limit: float = 300.0,
    memory_limit: int = 4096,
    progress: Callable[[FileOutcome], None] | None = None,
    retry: bool = False,
    reread: bool = False,
    reader: ExternalReader | None = None,
    read: ReadAny = iterate_shapes,
) -> IndexReport:
    """Bring a library up to date with mesh files.

    A file whose size and time are known is not opened; one whose content is known is not described again,
    even under another name; unless the reader's options are others now. The rest is described by worker
    processes and stored as it comes in, one transaction per file: whatever ends the run, files already stored
    stay. What fails though its content gave shapes before keeps these. Call it under
    ``if __name__ == "__main__":``, as everything that starts processes.

    Parameters
    ----------
    library : Library
        Open for writing.
    paths : sequence of str or Path
        Mesh files, as `find_meshes` lists them.
    jobs : int, optional
        Worker processes; one for each processor when left out.
    time_limit : float
        Seconds that reading one file may take, and describing one shape.
    memory_limit : int
        Megabytes that reading one file, or describing one shape, may need. Enforced on Linux only.
    progress : callable, optional
        Called with each `FileOutcome`.
    retry : bool
        Try files again that failed before and have not changed since. They are reported as failed otherwise.
    reread : bool
        Read and describe all files again, changed or not.
    reader : ExternalReader, optional
        For files that this package does not read.
    read : callable
        How the workers read a file; a function that can be imported by its name.

    Returns
    -------
    report : IndexReport

    Raises
    ------
    LibraryError
        If the library cannot be written.
    """
    started = time.monotonic()
    run = _Run(library, progress, reader, retry=retry, reread=reread)
    changed = run.pass_over_unchanged(paths)
    jobs = jobs or default_jobs()
    # One of our own files is one shape; what another program reads may hold thousands.
    if reader is None or not any(path.suffix.lower() in reader.suffixes for path in changed):
        jobs = min(jobs, max(len(changed), 1))
    with (
        single_threaded(),
        Workers(
            partial(read, reader=reader),
            library.model,
            jobs=jobs,
            time_limit=time_limit,
            memory_limit=memory_limit,
        ) as workers,
    ):
        for path in changed:
            run.begin(path, workers)
            while len(workers) >= AHEAD * jobs:
                run.store_finished(workers)
        while len(workers):
            run.store_finished(workers)
    return IndexReport(
        added=run.counts["added"],
        updated=run.counts["updated"],
        unchanged=run.counts["unchanged"],
        shapes=run.shapes,
        failed=run.failed,
        seconds=time.monotonic() - started,
    )


class ReadAny(Protocol):
    """A function like `iterate_shapes`."""

    def __call__(self, path: Path, reader: ExternalReader | None) -> Iterator[FoundShape | str]:
        """Yield the shapes of a file, or sentences on what could not be read."""


class _Run:
    """One run of `index_files`: what is known, what the workers have, what came out."""

    def __init__(
        self,
        library: Library,
        progress: Callable[[FileOutcome], None] | None,
        reader: ExternalReader | None,
        *,
        retry: bool,
        reread: bool,
    ) -> None:
        self.counts: Counter[str] = Counter()
        self.shapes = 0
        self.failed: list[tuple[Path, str]] = []
        self._library = library
        self._progress = progress
        self._reader = reader
        self._retry = retry
        self._reread = reread
        self._known = library.sources()
        self._failures: dict[ContentKey, tuple[Path, Failure]] = {}
        # The files of each content that the workers have; they read the first one.
        self._waiting: dict[ContentKey, list[FileState]] = {}

    @cached_property
    def _shape_ids(self) -> dict[ContentKey, dict[int, str]]:
        """The shapes that each known content gave: their ids, and the names of their objects."""
        shapes: defaultdict[str, dict[int, str]] = defaultdict(dict)
        for shape in self._library.shapes():
            shapes[shape.source][shape.shape_id] = shape.object_name
        return {
            content_key(Path(source.path), source.sha256): shapes[source.path]
            for source in self._known.values()
            if source.sha256 is not None and source.error is None and source.path in shapes
        }

    def _again(self, source: SourceRecord) -> bool:
        """Whether a file is read again though it has not changed."""
        if self._reread or (self._retry and source.error is not None):
            return True
        return source.sha256 is not None and choices_of(source.sha256) != self._choices(Path(source.path))

    def _choices(self, path: Path) -> str:
        return "" if self._reader is None else self._reader.choices_for(path)

    def pass_over_unchanged(self, paths: Iterable[str | Path]) -> list[Path]:
        """Deal with the files whose size and time are known; returns the others, which must be opened."""
        changed = []
        for path in dict.fromkeys(absolute(path) for path in paths):
            source = self._known.get(str(path))
            try:
                size_and_time = stamp(path)
            except OSError as error:
                self._fail(path, _unreadable(path, error))
                continue
            if source is None or (source.size, source.mtime_ns) != size_and_time or self._again(source):
                changed.append(path)
            else:
                self._note_unchanged(path, source)
        return changed

    def begin(self, path: Path, workers: Workers) -> None:
        """Store a file whose content is known, or hand it to the workers."""
        try:
            file = examine(path, self._choices(path))
        except OSError as error:
            self._fail(path, _unreadable(path, error))
            return
        source = self._known.get(str(path))
        if source is not None and source.sha256 == file.sha256 and not self._again(source):
            self._library.update_source(path, size=file.size, mtime_ns=file.mtime_ns)
            self._note_unchanged(path, source)
        elif file.key in self._waiting:
            self._waiting[file.key].append(file)
        elif file.key in self._failures:
            self._store_failure(file, _as_copy(file, *self._failures[file.key]))
        elif file.key in self._shape_ids and not self._reread:
            self._store(file, self._described_before(file))
        else:
            self._waiting[file.key] = [file]
            workers.submit(path)

    def store_finished(self, workers: Workers) -> None:
        """Wait for the workers and store what they finished, with the copies that waited for it."""
        for path, result in workers.finished():
            key = next(key for key, files in self._waiting.items() if files[0].path == path)
            first, *copies = self._waiting.pop(key)
            if first.changed():
                # What was read may be neither the old content nor the new.
                self._fail(
                    path, Failure(f"{path.name!r} changed or vanished while it was read; index it again")
                )
                for copy in copies:
                    self.begin(copy.path, workers)
            elif isinstance(result, Failure):
                self._failures[key] = path, result
                self._store_failure(first, result)
                for copy in copies:
                    self._store_failure(copy, _as_copy(copy, path, result))
            else:
                for file in (first, *copies):
                    self._store(file, result)

    def _described_before(self, file: FileState) -> DescribedFile:
        """Take from the library what a file of the same content gave."""
        return DescribedFile(
            tuple(
                DescribedShape(name, self._library.signature(shape_id), self._library.thumbnail(shape_id))
                for shape_id, name in self._shape_ids[file.key].items()
            )
        )

    def _store(self, file: FileState, described: DescribedFile) -> None:
        shapes = [
            NewShape(shape.signature, shape.object_name or file.path.name, shape.object_name, shape.thumbnail)
            for shape in described.shapes
        ]
        if described.problem and self._shapes_before(file) > len(shapes):
            self._keep(file, Failure(described.problem))
            return
        before = self._replace(file, shapes=shapes, error=described.problem or None)
        self.shapes += len(shapes)
        if described.problem:
            # What could be described is there; the file counts as failed, since something is missing.
            self._fail(file.path, Failure(described.problem))
            return
        known = before is not None and before.shape_count > 0
        self._note(FileOutcome(file.path, "updated" if known else "added"))

    def _store_failure(self, file: FileState, failure: Failure) -> None:
        if self._shapes_before(file):
            self._keep(file, failure)
            return
        if failure.lasting:
            # Remembered, so that a file that takes all its time or crashes is not tried in every run.
            self._replace(file, error=failure.reason)
        self._fail(file.path, failure)

    def _shapes_before(self, file: FileState) -> int:
        """How many shapes the library has of the very content that a file has now."""
        before = self._known.get(str(file.path))
        if before is None or before.sha256 is None or content_of(before.sha256) != content_of(file.sha256):
            return 0
        return before.shape_count

    def _keep(self, file: FileState, failure: Failure) -> None:
        """Fail a file that gave shapes before, and keep these: its content is still the same."""
        reason = f"{failure.reason} (its shapes of an earlier run were kept)"
        self._fail(file.path, replace(failure, reason=reason))

    def _replace(
        self, file: FileState, shapes: Sequence[NewShape] = (), error: str | None = None
    ) -> SourceRecord | None:
        """Put in what a file gives now; returns what was known of the file before."""
        before = self._known.get(str(file.path))
        if before is not None and before.sha256 is not None:
            # The shapes of the old content go away with it.
            self._shape_ids.pop(content_key(file.path, before.sha256), None)
        shape_ids = self._library.replace_source(
            file.path, size=file.size, mtime_ns=file.mtime_ns, sha256=file.sha256, shapes=shapes, error=error
        )
        if shape_ids and error is None:
            self._shape_ids[file.key] = dict(
                zip(shape_ids, (shape.object_name for shape in shapes), strict=True)
            )
        return before

    def _note_unchanged(self, path: Path, source: SourceRecord) -> None:
        if source.error is None:
            self._note(FileOutcome(path, "unchanged"))
        else:
            self._fail(path, Failure(f"{source.error} (found in an earlier run; --retry tries it again)"))

    def _fail(self, path: Path, failure: Failure) -> None:
        self.failed.append((path, failure.reason))
        self._note(FileOutcome(path, "failed", failure.reason, failure.details))

    def _note(self, outcome: FileOutcome) -> None:
        self.counts[outcome.status] += 1
        if self._progress is not None:
            self._progress(outcome)


def _unreadable(path: Path, error: OSError) -> Failure:
    return Failure(
        f"{path.name!r} cannot be read: {error.strerror or error}; check that it is there and is yours"
    )


def _as_copy(copy: FileState, first: Path, failure: Failure) -> Failure:
    return Failure(f"{copy.path.name!r} has the same content as '{first}', which failed: {failure.reason}")
