# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for duplicates in the worker process, while the window stays usable."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs
from ..library.model import model_source
from ..translation import counted, error_text, tr
from .properties import show_groups

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core import ShapeModel, ShapeSignature

    from .groups import Group, SceneShapes, Solid

__all__ = ["BackgroundSearch", "LibrarySearch", "SimilarSearch", "group_solids", "summary"]

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
    """Search of a scene: describes its meshes, a few at a time, and groups them."""

    def __init__(self, model: ShapeModel, found: SceneShapes, least: float) -> None:
        from .groups import solid_shapes

        super().__init__()
        self._model, self._least, self._hidden = model, least, len(found.hidden)
        self._source = model_source(bpy.context)
        self._solids, self._meshes = solid_shapes(found)
        self._signatures: list[ShapeSignature | str] = []

    def begin(self) -> None:
        """Start with the first meshes."""
        self.start(self._progress())
        self.go_on()

    def go_on(self) -> None:
        """Describe the next meshes; after the last ones, group them and show the groups."""
        from shapegoogle_core.worker.requests import describe_meshes

        count = len(self._signatures)
        if count < len(self._meshes):
            batch = self._meshes[count : count + MESHES_AT_ONCE]
            self.submit(self._take, describe_meshes, self._source, batch)
            return
        shown = bpy.context.window_manager.shape_google_duplicates
        show_groups(
            shown, group_solids(self._model, self._solids, self._signatures, self._least), "SCENE", add=True
        )
        self.end(summary(shown, self._hidden))

    def _progress(self) -> str:
        return tr("Comparing shapes: {done} of {count}").format(
            done=len(self._signatures), count=len(self._meshes)
        )

    def _take(self, signatures: list[ShapeSignature | str]) -> None:
        self._signatures += signatures
        shown = bpy.context.window_manager.shape_google_duplicates
        shown.progress = len(self._signatures) / len(self._meshes)
        shown.status = self._progress()
        self.go_on()


class LibrarySearch(BackgroundSearch):
    """Search of a library."""

    def take(self, groups: Sequence[Any]) -> None:
        """Show the groups of a library."""
        from .groups import library_groups

        shown = bpy.context.window_manager.shape_google_duplicates
        show_groups(shown, library_groups(groups), "LIBRARY")
        self.end(summary(shown))


def group_solids(
    model: ShapeModel,
    solids: Sequence[Solid],
    signatures: Sequence[ShapeSignature | str],
    least: float,
) -> list[Group]:
    """Group the geometries of a scene by their signatures.

    Parameters
    ----------
    model : ShapeModel
        The one that made the signatures.
    solids : sequence of Solid
    signatures : sequence of ShapeSignature or str
        Of each solid; a sentence in place of one that cannot be described, which is then in no group.
    least : float
        Least similarity to the first of a group.

    Returns
    -------
    groups : list of Group
    """
    from shapegoogle_core.library.duplicates.similar import group_similar

    from .groups import similar_groups

    described = [
        (solid, signature)
        for solid, signature in zip(solids, signatures, strict=True)
        if not isinstance(signature, str)
    ]
    groups = group_similar(model, [signature for _, signature in described], least)
    return similar_groups([solid for solid, _ in described], groups)


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
