# SPDX-License-Identifier: MIT
"""`IndexingRun`: the state of an indexing run, file by file."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from shapegoogle_core.indexing.files import (
    ContentKey,
    FileState,
    content_key,
    content_of,
    examine,
    stamp,
    unreadable,
)
from shapegoogle_core.indexing.plan import failed_before, is_read_again
from shapegoogle_core.indexing.progress.events import FileOutcome
from shapegoogle_core.indexing.progress.tracking import ProgressTracker
from shapegoogle_core.indexing.reading.describing import Failure
from shapegoogle_core.indexing.reading.external_reader import ExternalReader
from shapegoogle_core.indexing.reading.file_pool import DescribedFile, FilePool
from shapegoogle_core.indexing.reading.naming import file_based_name
from shapegoogle_core.indexing.reading.notes import LeftOut
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape, SourceRecord
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["IndexingRun"]


class IndexingRun:
    """State of one run: known files, files in work, results.

    Parameters
    ----------
    library : Library
    settings : IndexSettings
    reader : ExternalReader or None
    progress : callable or None
        Called with the `FileOutcome` of each file.
    tracker : ProgressTracker
    known : mapping of str to SourceRecord, optional
        What the library knows about the files, by path, in a run that others share.

    Attributes
    ----------
    counts : Counter of str
        Numbers of files by `FileOutcome.status`.
    shapes, updated_shapes, partial_shapes : int
    failed, warnings : list of (Path, str)
    left_out : list of LeftOut
    sizes : dict of Path to int
        Of the files seen so far.
    """

    def __init__(
        self,
        library: Library,
        settings: IndexSettings,
        reader: ExternalReader | None,
        progress: Callable[[FileOutcome], None] | None,
        tracker: ProgressTracker,
        known: Mapping[str, SourceRecord] | None = None,
    ) -> None:
        self.counts: Counter[str] = Counter()
        self.shapes = self.updated_shapes = self.partial_shapes = 0
        self.failed: list[tuple[Path, str]] = []
        self.warnings: list[tuple[Path, str]] = []
        self.left_out: list[LeftOut] = []
        self.sizes: dict[Path, int] = {}
        self._linked: dict[Path, None] = {}
        self._seconds: dict[Path, float] = {}
        self.tracker = tracker
        self._library = library
        self._settings = settings
        self.reader = reader
        self._progress = progress
        # Of some files only: others work on the rest, and their copies are not of interest here.
        self._shared = known is not None
        self._known = library.sources() if known is None else dict(known)
        self._lacking = library.sources_without_views()
        self._failures: dict[ContentKey, tuple[Path, Failure]] = {}
        # Files in work by their content; the first file of each content is read.
        self._waiting: dict[ContentKey, list[FileState]] = {}

    @cached_property
    def _shape_ids(self) -> dict[ContentKey, dict[int, str]]:
        """Shapes of each known content: their ids, and the names of their objects."""
        if self._shared:
            return {}
        shapes: defaultdict[str, dict[int, str]] = defaultdict(dict)
        for shape in self._library.shapes():
            shapes[shape.source][shape.shape_id] = shape.object_name
        return {
            content_key(Path(source.path), source.sha256): shapes[source.path]
            for source in self._known.values()
            if source.sha256 is not None
            and source.error is None
            and source.path in shapes
            and source.path not in self._lacking
        }

    def _again(self, source: SourceRecord) -> bool:
        return is_read_again(source, self._lacking, self._settings, self.reader)

    def _choices(self, path: Path) -> str:
        return "" if self.reader is None else self.reader.choices_for(path)

    def pass_over_unchanged(self, paths: Iterable[Path]) -> list[Path]:
        """Count the files of known size and time; returns the others, which must be opened."""
        changed = []
        for path in dict.fromkeys(paths):
            source = self._known.get(str(path))
            self.sizes[path] = 0
            try:
                size_and_time = stamp(path)
            except OSError as error:
                self._fail(path, Failure(unreadable(path, error)))
                continue
            self.sizes[path] = size_and_time[0]
            if source is None or (source.size, source.mtime_ns) != size_and_time or self._again(source):
                changed.append(path)
            else:
                self._note_unchanged(path, source)
        return changed

    def take_linked(self) -> list[Path]:
        """Return the files that have been read link to, as far as they have to be opened and are new."""
        linked, self._linked = list(self._linked), {}
        if not linked:
            return []
        self._library.add_roots(linked)
        new = [path for path in map(Path, self._library.source_paths(linked)) if path not in self.sizes]
        changed = self.pass_over_unchanged(new)
        for path in changed:
            self.tracker.add(path)
        return changed

    def begin(self, path: Path, pool: FilePool, *, first: bool = False) -> None:
        """Store a file whose content is known, or submit it to the pool."""
        try:
            file = examine(path, self._choices(path))
        except OSError as error:
            self._fail(path, Failure(unreadable(path, error)))
            self.tracker.passed_over(path)
            return
        source = self._known.get(str(path))
        if source is not None and source.sha256 == file.sha256 and not self._again(source):
            self._library.update_source(path, size=file.size, mtime_ns=file.mtime_ns)
            self._note_unchanged(path, source)
        elif file.key in self._waiting:
            self._waiting[file.key].append(file)
        elif file.key in self._failures:
            self._store_failure(file, _as_copy(file, *self._failures[file.key]))
        elif file.key in self._shape_ids and not self._settings.reread:
            self._store(file, self._described_before(file))
        else:
            self._waiting[file.key] = [file]
            pool.submit(path, first=first)
            return
        self.tracker.passed_over(path)

    def store_finished(self, pool: FilePool) -> None:
        """Wait for the pool and store the files it finished, with the copies that waited for them."""
        for finished in pool.finished():
            path, result = finished.path, finished.result
            self._seconds[path] = finished.seconds
            key = next(key for key, files in self._waiting.items() if files[0].path == path)
            first, *copies = self._waiting.pop(key)
            if first.changed():
                # The shapes may be those of neither the old content nor the new one.
                self._fail(
                    path, Failure(f"{path.name!r} changed or vanished while it was read; index it again")
                )
                for copy in copies:
                    self.begin(copy.path, pool)
            elif isinstance(result, Failure):
                self._failures[key] = path, result
                self._store_failure(first, result)
                for copy in copies:
                    self._store_failure(copy, _as_copy(copy, path, result))
            else:
                for file in (first, *copies):
                    self._store(file, result)

    def _described_before(self, file: FileState) -> DescribedFile:
        """Take the shapes of a file of the same content from the library."""
        return DescribedFile(
            tuple(self._stored(shape_id) for shape_id in self._shape_ids[file.key]),
        )

    def _stored(self, shape_id: int) -> NewShape[ShapeSignature]:
        """Take a shape out of the library."""
        record = self._library.shape(shape_id)
        path = Path(record.source)
        after_file = {file_based_name(path, record.object_name, alone=alone) for alone in (True, False)}
        return NewShape(
            self._library.signature(shape_id),
            record.name,
            record.object_name,
            self._library.thumbnail(shape_id),
            record.tags,
            self._library.placements(shape_id),
            origin=record.origin,
            named_after_file=record.name in after_file,
        )

    def _store(self, file: FileState, described: DescribedFile) -> None:
        # Copies of a file share the described shapes, but not the name.
        shapes = [
            replace(shape, name=_name(shape, file.path, alone=len(described.shapes) == 1))
            for shape in described.shapes
        ]
        notes = described.notes
        self.left_out += notes.left_out
        self._linked |= dict.fromkeys(path for path in map(Path, notes.linked) if path.is_file())
        if described.problem and self._shapes_before(file) > len(shapes):
            self._keep(file, Failure(described.problem))
            return
        before = self._replace(file, shapes=shapes, error=described.problem or None)
        self.shapes += len(shapes)
        warnings = tuple(dict.fromkeys(warning for shape in shapes for warning in shape.warnings))
        self.warnings += [(file.path, warning) for warning in warnings]
        if described.problem:
            self.partial_shapes += len(shapes)
            # The described shapes are stored, but the file counts as failed, since others are missing.
            self._fail(file.path, Failure(described.problem), len(shapes), warnings, notes.left_out)
            return
        known = before is not None and before.shape_count > 0
        self.updated_shapes += len(shapes) if known else 0
        outcome = FileOutcome(file.path, "updated" if known else "added", shapes=len(shapes))
        self._note(replace(outcome, warnings=warnings, left_out=notes.left_out))

    def _store_failure(self, file: FileState, failure: Failure) -> None:
        if self._shapes_before(file):
            self._keep(file, failure)
            return
        if failure.lasting:
            # Remembered, so that a file that exceeds its limits or crashes is not tried in every run.
            self._replace(file, error=failure.reason)
        self._fail(file.path, failure)

    def _shapes_before(self, file: FileState) -> int:
        """Count the shapes that the library has of the current content of a file."""
        before = self._known.get(str(file.path))
        if before is None or before.sha256 is None or content_of(before.sha256) != content_of(file.sha256):
            return 0
        return before.shape_count

    def _keep(self, file: FileState, failure: Failure) -> None:
        """Report a file as failed but keep its shapes of an earlier run, since its content is the same."""
        reason = f"{failure.reason} (its shapes of an earlier run were kept)"
        self._fail(file.path, replace(failure, reason=reason))

    def _replace(
        self, file: FileState, shapes: Sequence[NewShape[ShapeSignature]] = (), error: str | None = None
    ) -> SourceRecord | None:
        """Store the current shapes of a file; returns the former record of the file."""
        before = self._known.get(str(file.path))
        if before is not None and before.sha256 is not None:
            # The shapes of the former content are removed with it.
            self._shape_ids.pop(content_key(file.path, before.sha256), None)
        shape_ids = self._library.replace_source(
            file.path,
            size=file.size,
            mtime_ns=file.mtime_ns,
            sha256=file.sha256,
            shapes=shapes,
            error=error,
            # Another run may have stored this content since this one began.
            claim=before is None or before.sha256 != file.sha256,
        )
        if len(shape_ids) == len(shapes) > 0 and error is None:
            self._shape_ids[file.key] = dict(
                zip(shape_ids, (shape.object_name for shape in shapes), strict=True)
            )
        return before

    def _note_unchanged(self, path: Path, source: SourceRecord) -> None:
        if source.error is None:
            self._note(FileOutcome(path, "unchanged"))
        else:
            self._fail(path, Failure(failed_before(source)))

    def _fail(
        self,
        path: Path,
        failure: Failure,
        shapes: int = 0,
        warnings: tuple[str, ...] = (),
        left_out: tuple[LeftOut, ...] = (),
    ) -> None:
        self.failed.append((path, failure.reason))
        outcome = FileOutcome(path, "failed", failure.reason, failure.details, shapes)
        self._note(replace(outcome, warnings=warnings, left_out=left_out))

    def _note(self, outcome: FileOutcome) -> None:
        self.counts[outcome.status] += 1
        self.tracker.file_done(outcome.path)
        if self._progress is not None:
            self._progress(replace(outcome, seconds=self._seconds.pop(outcome.path, 0.0)))


def _name(shape: NewShape[ShapeSignature], path: Path, *, alone: bool) -> str:
    """Name a shape of a file: copies of a file share their shapes, but not the name of the file."""
    if not shape.object_name:
        return path.name
    if not shape.named_after_file:
        return shape.name
    name = file_based_name(path, shape.object_name, alone=alone)
    return name if shape.origin.frame is None else f"{name} @ {shape.origin.frame}"


def _as_copy(copy: FileState, first: Path, failure: Failure) -> Failure:
    return Failure(f"{copy.path.name!r} has the same content as '{first}', which failed: {failure.reason}")
