# SPDX-License-Identifier: GPL-3.0-or-later
"""Index the open scene: its meshes and point clouds as they are now, saved or not.

Objects that show the same mesh are read and described once.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs, state
from ..scene.selection import asset_tags, shape_objects, split_evaluated
from .open_file import is_unsaved, open_source, take_over
from .sharing import SharedMeshes

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core import Mesh, ShapeSignature
    from shapegoogle_core.cli.events import Event
    from shapegoogle_core.library.placement import Placement
    from shapegoogle_core.library.storage.records import NewShape
    from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["SceneIndexing"]

# Blender's z.
UP_AXIS = 2
# Meshes in the hands of the worker: enough that it never waits, few enough to keep memory flat.
AHEAD = 3
# How long the window may be kept from answering by reading objects.
SECONDS_OF_READING = 0.1


@dataclass
class _Entry:
    """A mesh on its way into the library, and the objects that show it.

    Attributes
    ----------
    first : Placement
        Of the first object.
    mesh : Mesh or None
        As the first object places it; kept only if other objects may show it too.
    objects : list of (str, array)
        Name and matrix of each object.
    uids : list of int
        Session numbers of the objects.
    tags : list of str
    described : NewShape or str or None
        A sentence if it cannot be described; None until the worker is done.
    """

    first: Placement
    mesh: Mesh | None
    objects: list[tuple[str, FloatArray]] = field(default_factory=list)
    uids: list[int] = field(default_factory=list)
    tags: list[str] = field(default_factory=list)
    described: NewShape[ShapeSignature] | str | None = None

    def add(self, item: Any, matrix: FloatArray) -> None:
        """Add an object that shows the mesh."""
        self.objects.append((item.name, matrix))
        self.uids.append(item.session_uid)
        self.tags += [tag for tag in asset_tags(item) if tag not in self.tags]


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
        self._error = ""
        self.exit_code: int | None = None
        self.reported = False
        self._started = time.monotonic()
        self._library, self._model = library, model
        self._opened = state.current().library.opened
        # What is not evaluated has neither its modifiers nor, perhaps, its place.
        shown, _ = split_evaluated(shape_objects(context.scene.objects), context)
        # Numbers, not objects: those may be gone when it is their turn.
        self._waiting = deque(item.session_uid for item in shown)
        self._total = len(self._waiting)
        self._first_described: tuple[float, int] | None = None
        self._meshes: SharedMeshes[_Entry] = SharedMeshes(shown)
        self._entries: list[_Entry] = []
        self._tasks: dict[Future[Any], _Entry] = {}
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
        from shapegoogle_core import LibraryError, ShapeGoogleError
        from shapegoogle_core.cli.command import DONE, UNUSABLE

        if self.exit_code is not None:
            return []
        try:
            if state.current().library.opened != self._opened:
                raise LibraryError(
                    "another file was opened while the scene was read, so nothing of it was stored; open the "
                    "first file and index it again"
                )
            events = self._take_finished()
            self._submit()
            if not self._tasks and not self._waiting:
                events.append(self._store())
                self.exit_code = DONE
        except ShapeGoogleError as error:
            self.cancel()
            self._error = str(error)
            self.exit_code = UNUSABLE
            return []
        return events

    def _submit(self) -> None:
        """Read some objects, and hand new meshes to the worker."""
        from shapegoogle_core import Library, MeshError, load_model

        if not self._library.exists():
            Library.open(self._library, load_model(self._model)).close()
        end = time.monotonic() + SECONDS_OF_READING
        here = {item.session_uid: item for item in bpy.context.scene.objects}
        depsgraph = bpy.context.evaluated_depsgraph_get()
        while self._waiting and len(self._tasks) < AHEAD and time.monotonic() < end:
            item = here.get(self._waiting.popleft())
            if item is None:
                self._total -= 1  # deleted meanwhile
                continue
            try:
                self._read(item, depsgraph)
            except MeshError as error:
                self._failed.append((item.name, str(error)))

    def _read(self, item: Any, depsgraph: Any) -> None:
        """Add an object to the entry of its mesh, or make a new entry."""
        import numpy as np

        from shapegoogle_core.library.placement import placements_of
        from shapegoogle_core.library.storage.records import NewShape
        from shapegoogle_core.worker.requests import describe

        from ..scene.meshes import evaluated_arrays, placed_mesh

        evaluated = item.evaluated_get(depsgraph)
        matrix, content = evaluated.matrix_world, self._meshes.content(evaluated)
        entry = None if content is None else self._meshes.find(item, matrix, content)
        if entry is None:
            vertices, faces = evaluated_arrays(item, depsgraph)
            if not len(faces) and (item.type == "MESH" or not len(vertices)):
                self._total -= 1  # wires and single points are helpers, as in files
                return
            content = self._meshes.read(evaluated, vertices, faces)
            entry = self._meshes.find(item, matrix, content)
            if entry is None:
                mesh = placed_mesh(item.name, vertices, faces, np.array(matrix, np.float64))
                place = np.array(matrix, np.float64)
                (first,) = placements_of(mesh, [(item.name, place)])
                entry = _Entry(first, mesh if self._meshes.is_shared(item) else None)
                self._entries.append(entry)
                self._meshes.put(item, matrix, content, entry)
                shape = NewShape(mesh, item.name, item.name, up_axis=UP_AXIS)
                self._tasks[jobs.worker().submit(describe, self._library, shape)] = entry
        entry.add(item, np.array(matrix, np.float64))

    def _take_finished(self) -> list[Event]:
        from shapegoogle_core import ShapeGoogleError
        from shapegoogle_core.indexing import FileOutcome

        events: list[Event] = []
        for task in [task for task in self._tasks if task.done()]:
            entry = self._tasks.pop(task)
            name = entry.objects[0][0]
            try:
                entry.described = task.result()
            except ShapeGoogleError as error:  # the process died over it: the others go on
                entry.described = str(error)
            if isinstance(entry.described, str):
                self._failed.append((name, entry.described))
                events.append(FileOutcome(Path(name), "failed", entry.described))
            else:
                events.append(FileOutcome(Path(name), "added", shapes=1))
        return [*events, self._progress()] if events else []

    def _progress(self) -> Event:
        from shapegoogle_core.indexing import IndexingProgress

        now = time.monotonic()
        waiting = len(self._tasks)
        done = len(self._entries) - waiting
        # Of those that have not been read, as many share a mesh as of the others.
        read = self._total - len(self._waiting)
        expected = round(len(self._waiting) * len(self._entries) / max(read, 1))
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

    def _store(self) -> Event:
        from shapegoogle_core import Library
        from shapegoogle_core.indexing import IndexSummary
        from shapegoogle_core.library.placement import placements_of

        # First, since a file saved meanwhile is another source than before.
        take_over()
        source = open_source()
        shapes = []
        known = state.current().library.objects
        for entry in self._entries:
            if entry.described is not None and not isinstance(entry.described, str):
                placements: tuple[Placement, ...] = (entry.first,)
                if entry.mesh is not None:
                    placements = placements_of(entry.mesh, entry.objects)
                shapes.append(replace(entry.described, placements=placements, tags=tuple(entry.tags)))
                for (name, _), uid in zip(entry.objects, entry.uids, strict=True):
                    known[source, name] = uid
        with Library.open(self._library) as library:
            size = None
            if is_unsaved(source):
                state.current().library.unsaved_in.add(self._library)
            elif Path(source).is_file():
                library.add_roots([source])
                size = Path(source).stat().st_size
            # Without a time or a hash: what is indexed is not what is in the file, which is read again when
            # its folder is indexed.
            library.replace_source(source, size=size, mtime_ns=None, sha256=None, shapes=shapes)
            count = len(library)
        return IndexSummary(
            added=1,
            added_shapes=len(shapes),
            failed=tuple(self._failed),
            library_shapes=count,
            seconds=time.monotonic() - self._started,
            scene=True,
        )
