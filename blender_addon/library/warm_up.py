# SPDX-License-Identifier: GPL-3.0-or-later
"""Opening the library in the worker process ahead of the first query."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs, state
from ..preferences import preferences
from ..state import session_of

if TYPE_CHECKING:
    from concurrent.futures import Future

__all__ = ["warm_up"]


def warm_up(context: Any) -> None:
    """Have the worker process open the library in a moment, once for each; cheap enough for a panel's draw.

    Whoever looks at a panel is about to query the library, or to paint. The core is imported for this process
    too, in another thread, since the import would block the window for half a second.

    Parameters
    ----------
    context : bpy.types.Context
    """
    library: Path = preferences(context).library_path()
    warm = state.current().library.warm
    if library in warm or bpy.app.background:
        return
    warm.add(library)

    def ask(tasks: ModuleType) -> None:
        if library in state.current().library.warm:  # else the add-on was switched off meanwhile
            jobs.watch(jobs.worker().submit(tasks.warm_up, library), _show_count, ignore)

    def ignore(_error: BaseException) -> None:
        """Leave it to the next query to report the error."""

    jobs.watch(_import_core(), ask, ignore)


def _show_count(shapes: int) -> None:
    session_of(bpy.context).shape_count = shapes


def _import_core() -> Future[ModuleType]:
    """Import in another thread the functions that tasks are sent with; numpy comes along."""
    from concurrent.futures import ThreadPoolExecutor

    importer = ThreadPoolExecutor(1)
    imported = importer.submit(importlib.import_module, "shapegoogle_core.service.requests")
    importer.shutdown(wait=False)
    return imported
