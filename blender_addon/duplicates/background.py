# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for duplicates in the worker process, while the window stays usable."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs
from ..translation import counted, error_text, tr
from .properties import show_groups

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core import Mesh
    from shapegoogle_core.model import ShapeSignature
    from shapegoogle_core.worker.packed import Packed

    from .groups import Solid

__all__ = ["BackgroundSearch", "LibrarySearch", "SimilarSearch", "summary"]

# Meshes handed to the worker at once: another query waits for no more than these.
MESHES_AT_ONCE = 4


class BackgroundSearch:
    """A search for duplicates that runs in the worker process."""

    def __init__(self) -> None:
        self.future: Future[Any] | None = None

    def start(self, text: str) -> None:
        """Show that the search runs."""
        shown = bpy.context.window_manager.shape_google_duplicates
        shown.running, shown.progress, shown.status = True, 0.0, text

    def submit(self, done: Any, function: Any, *arguments: object) -> None:
        """Have the worker call a function of the core; `done` takes its result."""
        self.future = jobs.worker().submit(function, *arguments)
        jobs.watch(self.future, done, self.fail)

    def fail(self, error: BaseException) -> None:
        """End the search with an error."""
        self.end(error_text(error) or tr("Stopped; the groups found so far are listed"))

    def end(self, text: str) -> None:
        """Show that the search has ended, and how."""
        self.future = None
        shown = bpy.context.window_manager.shape_google_duplicates
        shown.running, shown.status = False, text

    def cancel(self) -> None:
        """Cancel the task that waits; the groups found so far stay listed."""
        if self.future is not None:
            self.future.cancel()
            self.end(tr("Cancelled; the groups found so far are listed"))


class SimilarSearch(BackgroundSearch):
    """Search of a scene: has its meshes described, a few at a time, and grouped.

    Parameters
    ----------
    source : Path or str
        The model, see `model_source`.
    solids : sequence of Solid
        The geometries of the scene.
    meshes : sequence of Mesh
        Of each.
    hidden : int
        Number of objects that Blender does not evaluate.
    least : float
        Least similarity to the first of a group.
    """

    def __init__(
        self, source: Path | str, solids: Sequence[Solid], meshes: Sequence[Mesh], hidden: int, least: float
    ) -> None:
        super().__init__()
        self._source, self._solids, self._meshes = source, solids, meshes
        self._hidden, self._least = hidden, least
        self._described: list[Packed[ShapeSignature] | str] = []

    def begin(self) -> None:
        """Start with the first meshes."""
        self.start(self._progress())
        self.go_on()

    def go_on(self) -> None:
        """Have the next meshes described; after the last ones, all of them grouped."""
        from shapegoogle_core.worker.grouping import describe_meshes, group_meshes

        count = len(self._described)
        if count < len(self._meshes):
            batch = self._meshes[count : count + MESHES_AT_ONCE]
            self.submit(self._take, describe_meshes, self._source, batch)
        else:
            self.submit(self._show, group_meshes, self._source, self._described, self._least)

    def _progress(self) -> str:
        return tr("Comparing shapes: {done} of {count}").format(
            done=len(self._described), count=len(self._meshes)
        )

    def _take(self, described: list[Packed[ShapeSignature] | str]) -> None:
        self._described += described
        shown = bpy.context.window_manager.shape_google_duplicates
        shown.progress = len(self._described) / len(self._meshes)
        shown.status = self._progress()
        self.go_on()

    def _show(self, groups: list[list[tuple[int, float]]]) -> None:
        from .groups import similar_groups

        shown = bpy.context.window_manager.shape_google_duplicates
        show_groups(shown, similar_groups(self._solids, groups), "SCENE", add=True)
        self.end(summary(shown, self._hidden))


class LibrarySearch(BackgroundSearch):
    """Search of a library."""

    def take(self, groups: Sequence[Any]) -> None:
        """Show the groups of a library."""
        from .groups import library_groups

        shown = bpy.context.window_manager.shape_google_duplicates
        show_groups(shown, library_groups(groups), "LIBRARY")
        self.end(summary(shown))


def summary(shown: Any, hidden: int = 0) -> str:
    """Summarise the groups found, and how many objects were left out.

    Parameters
    ----------
    shown : SHAPEGOOGLE_PG_duplicates
    hidden : int
        Number of objects that Blender does not evaluate.

    Returns
    -------
    text : str
    """
    count = len(shown.groups)
    if shown.found_in == "SCENE":
        found = counted("{count} group in this scene", "{count} groups in this scene", count)
        text = found if count else tr("No duplicates in this scene")
    else:
        found = counted("{count} group in the library", "{count} groups in the library", count)
        text = found if count else tr("No duplicates in the library")
    if not hidden:
        return text
    return counted(
        "{summary}; {count} hidden object was left out",
        "{summary}; {count} hidden objects were left out",
        hidden,
        summary=text,
    )
