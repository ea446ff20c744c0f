# SPDX-License-Identifier: GPL-3.0-or-later
"""The open scene as a source of the library: its meshes and point clouds as they are now, saved or not."""

from __future__ import annotations

import os
import time
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs
from ..scene.selection import asset_tags, shape_objects, split_evaluated

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core.cli.events import Event

__all__ = ["SceneIndexing", "file_of", "is_here", "scene_source"]

# Blender's z.
UP_AXIS = 2
# Objects in the hands of the worker: enough that it never waits, few enough to keep memory flat.
AHEAD = 3
# The scene and its file are two sources: each has its own objects, and may change without the other.
MARK = " (open scene)"


def scene_source() -> str:
    """Return the name of the open scene in the library."""
    return f"{bpy.data.filepath or 'Unsaved'}{MARK}"


def file_of(source: str) -> str:
    """Return the file that a source of the library is, or that a scene was saved in."""
    return source.removesuffix(MARK)


def is_here(source: str, object_name: str) -> bool:
    """Whether a shape of the library is an object of the open scene.

    Parameters
    ----------
    source : str
        The open scene, or the file that it was saved in.
    object_name : str

    Returns
    -------
    here : bool
    """
    file = os.path.normcase(file_of(source))
    return file == os.path.normcase(file_of(scene_source())) and object_name in bpy.context.scene.objects


class SceneIndexing:
    """The worker process describes the objects one after the other; they are stored all at once at the end.

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
        self._error = ""
        self.exit_code: int | None = None
        self.reported = False
        self._started = time.monotonic()
        self._library, self._model = library, model
        self._source = scene_source()
        # What is not evaluated has neither its modifiers nor, perhaps, its place.
        shown, _ = split_evaluated(shape_objects(context.scene.objects), context)
        # Names, not objects: those may be gone when it is their turn.
        self._waiting = deque(item.name for item in shown)
        self._total = len(self._waiting)
        self._tasks: dict[Future[Any], str] = {}
        self._described: list[tuple[str, Any]] = []
        self._failed: list[tuple[str, str]] = []

    def last_words(self) -> str:
        """Return why it ended."""
        return self._error or f"exit code {self.exit_code}"

    def join(self) -> None:
        """Wait until the next object is described."""
        from concurrent.futures import FIRST_COMPLETED, wait

        if self.exit_code is None and self._tasks:
            wait(self._tasks, return_when=FIRST_COMPLETED)

    def cancel(self) -> None:
        """Stop describing; nothing is stored."""
        from shapegoogle_core.cli.command import INTERRUPTED

        self.exit_code = INTERRUPTED
        for task in self._tasks:
            task.cancel()
        self._tasks.clear()

    def events(self) -> list[Event]:
        """Report the objects described since the last call; stores all after the last one."""
        from shapegoogle_core import ShapeGoogleError
        from shapegoogle_core.cli.command import DONE, UNUSABLE

        if self.exit_code is not None:
            return []
        try:
            events = self._take_finished()
            self._submit()
            if not self._tasks:
                events.append(self._store())
                self.exit_code = DONE
        except ShapeGoogleError as error:
            self.cancel()
            self._error = str(error)
            self.exit_code = UNUSABLE
            return []
        return events

    def _submit(self) -> None:
        """Read some objects and hand them to the worker."""
        from shapegoogle_core import Library, MeshError, load_model
        from shapegoogle_core.library.storage.records import NewShape
        from shapegoogle_core.service.requests import describe

        from ..scene.meshes import evaluated_mesh

        if not self._library.exists():
            Library.open(self._library, load_model(self._model)).close()
        while self._waiting and len(self._tasks) < AHEAD:
            name = self._waiting.popleft()
            item = bpy.context.scene.objects.get(name)
            if item is None:
                self._total -= 1  # deleted meanwhile
                continue
            try:
                mesh = evaluated_mesh(item)
            except MeshError as error:
                self._failed.append((name, str(error)))
                continue
            if mesh.is_point_cloud and (item.type == "MESH" or not len(mesh.vertices)):
                self._total -= 1  # wires and single points are helpers, as in files
                continue
            shape = NewShape(mesh, name, name, up_axis=UP_AXIS, tags=asset_tags(item))
            self._tasks[jobs.worker().submit(describe, self._library, shape)] = name

    def _take_finished(self) -> list[Event]:
        from shapegoogle_core import ShapeGoogleError
        from shapegoogle_core.indexing import FileOutcome

        events: list[Event] = []
        for task in [task for task in self._tasks if task.done()]:
            name = self._tasks.pop(task)
            try:
                result = task.result()
            except ShapeGoogleError as error:  # the process died over it: the others go on
                result = str(error)
            if isinstance(result, str):
                self._failed.append((name, result))
                events.append(FileOutcome(Path(name), "failed", result))
            else:
                self._described.append((name, result))
                events.append(FileOutcome(Path(name), "added", shapes=1))
        return [*events, self._progress()] if events else []

    def _progress(self) -> Event:
        from shapegoogle_core.indexing import IndexingProgress

        done = len(self._described) + len(self._failed)
        seconds = time.monotonic() - self._started
        left = max(self._total - done, 0)
        return IndexingProgress(
            files_done=0,
            files_total=1,
            bytes_done=0,
            bytes_total=0,
            shapes_done=done,
            shapes_waiting=left,
            seconds=seconds,
            seconds_left=seconds / done * left if done else None,
        )

    def _store(self) -> Event:
        from shapegoogle_core import Library
        from shapegoogle_core.indexing import IndexSummary

        shapes = [shape for _, shape in self._described]
        with Library.open(self._library) as library:
            # Without size or time, as it is no file: it is read again in every run.
            library.replace_source(self._source, size=None, mtime_ns=None, sha256=None, shapes=shapes)
            count = len(library)
        return IndexSummary(
            added=1,
            added_shapes=len(shapes),
            failed=tuple(self._failed),
            library_shapes=count,
            seconds=time.monotonic() - self._started,
            scene=True,
        )
