# SPDX-License-Identifier: GPL-3.0-or-later
"""Index the open scene: its shapes as they are now, saved or not.

First all meshes are written into a file; then they are described one after the other, and stored together at
the end. Only the first is work for the main thread.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import jobs, state
from ..translation import error_text, tr
from .address import library_address
from .open_file import is_unsaved, open_source, take_over
from .scene_reading import SceneReading

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core.cli.events import Event
    from shapegoogle_core.library.storage.records import NewShape
    from shapegoogle_core.model import ShapeSignature
    from shapegoogle_core.worker.packed import Packed
    from shapegoogle_core.worker.scene import SceneShape

__all__ = ["SceneIndexing"]

# Meshes in the hands of the worker: enough that it never waits, few enough to keep memory flat.
AHEAD = 3
# How long the window may be kept from answering by reading objects.
SECONDS_OF_READING = 0.1


class SceneIndexing:
    """The worker process describes one mesh after the other; they are stored all at once at the end.

    It has the methods and attributes of `jobs.BackgroundRun`.

    Parameters
    ----------
    context : bpy.types.Context
    library : Path
        Created if it does not exist.
    model : str
        Model of a new library, as `shapegoogle_core.load_model` takes it.
    """

    def __init__(self, context: Any, library: Path, model: str) -> None:
        from shapegoogle_core.processes.temporary import temporary_folder
        from shapegoogle_core.processes.worker import Worker
        from shapegoogle_core.worker.scene import create_library

        self._error = ""
        self.exit_code: int | None = None
        self.reported = False
        self._started = time.monotonic()
        self._library = library
        self._address = library_address(context)
        self._opened = state.current().library.opened
        self._resources = ExitStack()
        self._output = self._resources.enter_context(temporary_folder()) / "shapes.bin"
        self._reading = SceneReading(context, self._resources.enter_context(self._output.open("wb")))
        self._shapes: Iterator[SceneShape | None] | None = None
        self._all_submitted = False
        self._done = 0
        self._first_described: tuple[float, int] | None = None
        self._described: list[Packed[NewShape[ShapeSignature]]] = []
        self._tasks: dict[Future[Any], str] = {}
        self._failed: list[tuple[str, str]] = []
        self._created = None if library.exists() else jobs.worker().submit(create_library, library, model)
        # Not the worker that answers searches: relating thousands of shapes to the others takes a while.
        self._storer = Worker()
        self._resources.callback(self._storer.stop)
        self._source = ""
        self._stored: list[Future[Any]] = []

    @property
    def storing(self) -> bool:
        """Whether the shapes are being stored, or were."""
        return bool(self._stored)

    def last_words(self) -> str:
        """Return why it ended."""
        return self._error or tr("exit code {code}").format(code=self.exit_code)

    def join(self) -> None:
        """Wait until the next object is described, or all are stored."""
        from concurrent.futures import FIRST_COMPLETED, wait

        tasks = self._stored[-1:] or [*self._tasks, *([] if self._created is None else [self._created])]
        if self.exit_code is None and tasks:
            wait(tasks, return_when=FIRST_COMPLETED)

    def cancel(self) -> None:
        """Stop describing, and storing; until `storing` nothing is stored."""
        from shapegoogle_core.cli.command import INTERRUPTED

        self.exit_code = INTERRUPTED
        for task in self._tasks:
            task.cancel()
        self._tasks.clear()
        self._resources.close()

    def events(self) -> list[Event]:
        """Report the objects described since the last call; has all stored after the last one."""
        from shapegoogle_core import LibraryError, ShapeGoogleError
        from shapegoogle_core.cli.command import DONE, UNUSABLE

        if self.exit_code is not None:
            return []
        try:
            if self.storing:
                if not all(task.done() for task in self._stored):
                    return []
                events = [self._summary()]
                self.exit_code = DONE
                self._resources.close()
                return events
            if state.current().library.opened != self._opened:
                raise LibraryError(
                    "another file was opened while the scene was read, so nothing of it was stored; open the "
                    "first file and index it again"
                )
            events = self._take_finished()
            self._submit()
            if self._all_submitted and not self._tasks:
                self._store()
        except ShapeGoogleError as error:
            self.cancel()
            self._error = error_text(error)
            self.exit_code = UNUSABLE
            return []
        return events

    def _submit(self) -> None:
        """Read some objects; once all are read, hand shapes to the worker."""
        from shapegoogle_core.worker.scene import describe

        end = time.monotonic() + SECONDS_OF_READING
        if self._shapes is None:
            if not self._reading.read(SECONDS_OF_READING):
                return
            self._shapes = self._reading.shapes()
        if self._created is not None:
            if not self._created.done():
                return
            self._created.result()
            self._created = None
        while len(self._tasks) < AHEAD and time.monotonic() < end:
            for found in self._shapes:
                if found is not None:
                    self._tasks[jobs.worker().submit(describe, self._library, found)] = found.name
                    break
                if time.monotonic() >= end:
                    return
            else:
                self._all_submitted = True
                return

    def _take_finished(self) -> list[Event]:
        from shapegoogle_core import ShapeGoogleError
        from shapegoogle_core.indexing import FileOutcome

        events: list[Event] = []
        for task in [task for task in self._tasks if task.done()]:
            name = self._tasks.pop(task)
            self._done += 1
            try:
                described = task.result()
            except ShapeGoogleError as error:  # the process died over it: the others go on
                described = error_text(error)
            if isinstance(described, str):
                self._failed.append((name, described))
                events.append(FileOutcome(Path(name), "failed", described))
            else:
                self._described.append(described)
                events.append(FileOutcome(Path(name), "added", shapes=1))
        return [*events, self._progress()] if events else []

    def _progress(self) -> Event:
        from shapegoogle_core.indexing import IndexingProgress

        now = time.monotonic()
        waiting, done, expected = len(self._tasks), self._done, self._reading.expected
        seconds_left = None
        if not waiting + expected:
            seconds_left = 0.0
        elif self._first_described is None:
            # Before the first one the worker process started and loaded the model.
            self._first_described = now, done
        elif done > self._first_described[1]:
            since, first = self._first_described
            seconds_left = (now - since) / (done - first) * (waiting + expected)
        return IndexingProgress(
            files_done=0,
            files_total=0,
            bytes_done=0,
            bytes_total=0,
            shapes_done=done,
            shapes_waiting=waiting,
            shapes_expected=expected,
            seconds=now - self._started,
            seconds_left=seconds_left,
            scene=True,
        )

    def _store(self) -> None:
        """Have another process store the shapes."""
        from shapegoogle_core.worker.scene import find_neighbours, store

        # First, since a file saved meanwhile is another source than before.
        take_over(self._storer)
        self._source = source = open_source()
        known = state.current().library.objects
        uids = {item.name: item.uid for item in self._reading.items.values() if item.is_local}
        for shape in self._described:
            for name in shape.object_names:
                if name in uids:
                    known[source, name] = uids[name]
        is_file = not is_unsaved(source) and Path(source).is_file()
        size = Path(source).stat().st_size if is_file else None
        roots = [source] if is_file else []
        self._stored = [
            self._storer.submit(store, self._address, source, size, roots, self._described),
            self._storer.submit(find_neighbours, self._library),
        ]

    def _summary(self) -> Event:
        """Summarise what was stored, and note under which name."""
        from shapegoogle_core.indexing import IndexSummary
        from shapegoogle_core.indexing.reading.notes import LeftOut, total_left_out

        library = state.current().library
        written, related = self._stored
        written.result()
        if is_unsaved(self._source) and library.opened == self._opened:
            if open_source() == self._source:
                library.unsaved_in.add(self._library)
            else:  # it was saved while its shapes were stored
                library.renamed.append((self._library, self._source, open_source()))
                take_over()
        left_out = tuple(LeftOut(kind, number) for kind, number in self._reading.left_out.items() if number)
        return IndexSummary(
            added=1,
            added_shapes=len(self._described),
            failed=(*self._reading.failed, *self._failed),
            left_out=total_left_out(left_out),
            library_shapes=related.result(),
            seconds=time.monotonic() - self._started,
            scene=True,
        )
