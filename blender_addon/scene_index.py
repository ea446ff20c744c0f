# SPDX-License-Identifier: GPL-3.0-or-later
"""The open scene as a source of the library: its mesh objects as they are now, saved or not."""

from __future__ import annotations

import time
from collections import deque
from concurrent.futures import Future
from concurrent.futures import wait as wait_for
from pathlib import Path
from typing import Any

import bpy

from . import jobs, scene

__all__ = ["SceneIndexing", "scene_source"]

# Blender's z.
UP_AXIS = 2


def scene_source() -> str:
    """Return what the library calls the open file: its path, or a name for one that was never saved."""
    return bpy.data.filepath or "(unsaved scene)"


class SceneIndexing:
    """The worker process describes the objects one by one; stored all at once at the end.

    It has the methods and attributes of `jobs.BackgroundRun`.

    Parameters
    ----------
    context : bpy.types.Context
    library : Path
        Made if there is none.
    model : str
        For a new library: what `shapegoogle_core.load_model` calls it.
    """

    def __init__(self, context: Any, library: Path, model: str) -> None:
        self.lines: deque[str] = deque()
        self.exit_code: int | None = None
        self.reported = False
        self._started = time.monotonic()
        self._library, self._model = library, model
        self._source = scene_source()
        self._done = 0
        self._objects = scene.mesh_objects(context.scene.objects)
        self._names = [item.name for item in self._objects]
        self._tasks: list[Future[Any]] = []

    def _submit(self) -> None:
        """Read the objects and hand them to the worker; the library must be there by then."""
        from shapegoogle_core import Library, MeshError, load_model
        from shapegoogle_core.library.session import describe

        if not self._library.exists():
            Library.open(self._library, load_model(self._model)).close()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for item in self._objects:
            try:
                mesh = scene.evaluated_mesh(item, depsgraph)
            except MeshError as error:
                task: Future[Any] = Future()
                task.set_result(str(error))
            else:
                task = jobs.worker().submit(describe, self._library, mesh, UP_AXIS)
            self._tasks.append(task)

    def seconds(self) -> float:
        """Return for how long it has been running."""
        return time.monotonic() - self._started

    def join(self) -> None:
        """Wait until all is described."""
        if not self._tasks:
            self._submit()
        wait_for(self._tasks)

    def cancel(self) -> None:
        """Describe no more; nothing is stored."""
        for task in self._tasks:
            task.cancel()

    def events(self) -> list[dict[str, Any]]:
        """Report what was described since the last call; stores all after the last one."""
        from shapegoogle_core import ShapeGoogleError

        try:
            if not self._tasks and self._names:
                self._submit()
            events = self._described()
            if self._done == len(self._names) and self.exit_code is None:
                events.append(self._store())
                self.exit_code = 0
        except ShapeGoogleError as error:
            self.lines.append(str(error))
            self.exit_code = 2
            return []
        return events

    def _described(self) -> list[dict[str, Any]]:
        events = []
        while self._done < len(self._tasks) and self._tasks[self._done].done():
            if self._tasks[self._done].cancelled():
                self._done += 1
                continue
            result = self._tasks[self._done].result()
            failed = isinstance(result, str)
            events.append(
                {
                    "done": self._done + 1,
                    "total": len(self._names),
                    "path": self._names[self._done],
                    "status": "failed" if failed else "added",
                    "reason": result if failed else "",
                }
            )
            self._done += 1
        return events

    def _store(self) -> dict[str, Any]:
        from shapegoogle_core import Library
        from shapegoogle_core.library import NewShape

        results = [task.result() for task in self._tasks if not task.cancelled()]
        shapes = [
            NewShape(result.signature, name, name, result.thumbnail)
            for name, result in zip(self._names, results, strict=False)
            if not isinstance(result, str)
        ]
        with Library.open(self._library) as library:
            # No size or time: the scene is not the file, which is read when its folder is indexed.
            library.replace_source(self._source, size=None, mtime_ns=None, sha256=None, shapes=shapes)
            count = len(library)
        return {"added": len(shapes), "updated": 0, "unchanged": 0, "failed": [], "shapes": count}
