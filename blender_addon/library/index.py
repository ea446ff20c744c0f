# SPDX-License-Identifier: GPL-3.0-or-later
"""Index folders and the open scene into the library."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty

from .. import jobs, state
from ..jobs import BackgroundRun, redraw
from ..preferences import preferences
from ..state import session_of
from ..translation import counted, tr
from .address import NEEDS_FILE, is_on_server
from .present import refresh
from .properties import add_error
from .scene_source import SceneIndexing
from .sentences import progress_text, summary_text
from .status_bar import redraw_status_bar

__all__ = ["register", "unregister"]

SECONDS_BETWEEN_LOOKS = 0.25


class SHAPEGOOGLE_OT_index_library(bpy.types.Operator):
    """Bring the library up to date."""

    bl_idname = "shape_google.index_library"
    bl_label = "Index Library"
    bl_description = (
        "Put the shapes of all chosen sources into the library, in a background process. "
        "Only new and changed files are read, and no file is ever changed"
    )

    reread: BoolProperty(
        name="Read All Again", description="Also files that have not changed", options={"SKIP_SAVE"}
    )
    retry: BoolProperty(
        name="Retry Failed", description="Also files that failed before", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is something to index and nothing is being indexed."""
        chosen = preferences(context)
        if is_on_server(context):
            cls.poll_message_set(tr(NEEDS_FILE))
            return False
        if session_of(context).indexing:
            cls.poll_message_set(tr("Indexing is already running"))
            return False
        if not chosen.has_sources() and not chosen.use_scene:
            cls.poll_message_set(
                tr("Add a folder, or an asset library in Blender's preferences, or use this scene")
            )
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Start in the background."""
        if not self._start(context):
            return {"CANCELLED"}
        bpy.app.timers.register(_look, first_interval=SECONDS_BETWEEN_LOOKS, persistent=True)
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Index and wait for the end."""
        if not self._start(context):
            return {"CANCELLED"}
        session = session_of(context)
        running = state.current().library.indexing
        while running:
            running[0].join()
            _take(running[0])
        self.report({"WARNING"} if session.errors else {"INFO"}, session.summary)
        return {"FINISHED"}

    def _flags(self) -> list[str]:
        return [f"--{name}" for name in ("reread", "retry") if getattr(self, name)]

    def _start(self, context: Any) -> bool:
        chosen, session = preferences(context), session_of(context)
        path, sources = chosen.library_path(), chosen.sources()
        if not sources and not chosen.use_scene:
            self.report({"ERROR"}, tr("None of the chosen folders exists; add one, or connect its drive"))
            return False
        session.errors.clear()
        session.summary, session.done, session.total, session.share = "", 0, 0, 0.0
        session.progress = session.brief_progress = tr("Searching for files …")
        running = state.current().library.indexing
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if sources:
                arguments = [*_arguments(chosen, sources, path), *_roots_here(context), *self._flags()]
                running.append(BackgroundRun(arguments))
            if chosen.use_scene:
                running.append(SceneIndexing(context, path, chosen.model_name()))
        except OSError as error:
            while running:
                running.pop().cancel()
            text = tr("{path}: {reason}; choose another library")
            self.report({"ERROR"}, text.format(path=path, reason=error.strerror))
            return False
        state.current().library.indexed = path
        session.indexing = True
        return True


def _arguments(chosen: Any, sources: Sequence[Path], path: Path) -> list[str]:
    arguments = ["index", *map(str, sources), "--library", str(path)]
    arguments += ["--objects", chosen.objects.lower()]
    if chosen.frames:
        arguments += [f"--frames={chosen.frames}"]
    arguments += ["--time-limit", str(chosen.time_limit), "--memory-limit", str(chosen.memory_limit)]
    if chosen.jobs:
        arguments += ["--jobs", str(chosen.jobs)]
    if not path.exists():
        arguments += ["--model", chosen.model_name()]
    return arguments


def _roots_here(context: Any) -> list[str]:
    """Name the folders that roots of the library are on this computer, so that they are no further roots."""
    known = {root.name for root in session_of(context).roots}
    return [
        f"--root={name}={folder}" for name, folder in preferences(context).root_folders() if name in known
    ]


def _look() -> float | None:
    """Show the progress of the background run."""
    if not state.is_registered():
        return None
    running = state.current().library.indexing
    if running:
        _take(running[0])
        redraw()
        redraw_status_bar()
    return SECONDS_BETWEEN_LOOKS if running else None


def _take(run: BackgroundRun | SceneIndexing) -> None:
    """Show the events of a run, and its end."""
    from shapegoogle_core.indexing import FileOutcome, IndexingProgress, IndexSummary

    session = session_of(bpy.context)
    for event in run.events():
        match event:
            case IndexingProgress():
                if not event.scene:
                    session.done, session.total = event.files_done, event.files_total
                session.share, session.progress = event.share, progress_text(event)
                session.brief_progress = progress_text(event, brief=True)
            case FileOutcome(status="failed"):
                add_error(session, str(event.path), _worded(event.reason), event.details)
            case IndexSummary():
                run.reported = True
                library, sentence = state.current().library.indexed, summary_text(event)
                if len(event.failed) == 1 and not (event.added or event.updated or event.unchanged):
                    # Nothing else has happened: the reason need not be looked for in the list.
                    sentence = f"{sentence}: {_worded(event.failed[0][1])}"
                if library == preferences().library_path():
                    session.shape_count = event.library_shapes
                elif library is not None and not session.summary:
                    sentence = f"{library.name}: {sentence}"
                session.summary = f"{session.summary}; {sentence}" if session.summary else sentence
                # Files that were there but could not be read have their line already; folders have none.
                for source, reason in event.failed:
                    add_error(session, source, _worded(reason))
    running = state.current().library.indexing
    if run.exit_code is None or run not in running:
        return
    running.remove(run)
    # 1: some files failed, and are listed; or Blender could not even start the run.
    if run.exit_code not in (0, 1) or not run.reported:
        add_error(session, str(state.current().library.indexed), run.last_words())
        session.summary = session.summary or tr("Indexing stopped; Not Indexed says why")
    if not running:
        session.indexing = False
        session.progress = ""
        refresh(bpy.context)


def _worded(reason: str) -> str:
    """Replace options of the command by the buttons that take their place."""
    reason = reason.replace("--retry tries", "Retry Failed Files tries")
    return reason.replace("with what --verbose shows", "with what Copy Errors copies")


def _cancelled(running: Sequence[BackgroundRun | SceneIndexing], session: Any) -> str:
    """Say what a cancelled run has done; each file is stored when it is done, a scene as a whole."""
    parts = [session.summary] if session.summary else []
    if isinstance(running[0], BackgroundRun):
        if session.total:
            text = counted(
                "Cancelled after {done:,} of {count:,} file",
                "Cancelled after {done:,} of {count:,} files",
                session.total,
                done=session.done,
            )
        else:
            text = tr("Cancelled before any file was read")
        parts.append(text)
        if len(running) > 1:
            parts.append(tr("nothing of this scene was stored"))
    elif running[0].storing:
        parts.append(tr("Cancelled while this scene was being stored; index it again to complete it"))
    else:
        parts.append(tr("Cancelled; nothing of this scene was stored"))
    return "; ".join(parts)


class SHAPEGOOGLE_OT_cancel_indexing(bpy.types.Operator):
    """Stop indexing."""

    bl_idname = "shape_google.cancel_indexing"
    bl_label = "Cancel Indexing"
    bl_description = "Stop indexing; the shapes stored so far stay, and the next run continues from there"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that something is being indexed."""
        return bool(session_of(context).indexing)

    def execute(self, context: Any) -> set[str]:
        """Stop it."""
        running = state.current().library.indexing
        session = session_of(context)
        session.summary = _cancelled(running, session)
        jobs.end(running)
        session.indexing = False
        session.progress = ""
        refresh(context)  # the shapes stored so far stay
        return {"FINISHED"}


def _text_of(errors: Any) -> str:
    """Write all errors, each with its details, if it has any, in the lines below it."""
    lines = [f"{error.path}: {error.reason}\n{error.details}".rstrip() for error in errors]
    return "\n".join(lines)


class SHAPEGOOGLE_OT_copy_errors(bpy.types.Operator):
    """Copy the errors as text."""

    bl_idname = "shape_google.copy_errors"
    bl_label = "Copy Errors"
    bl_description = (
        "Copy all errors to the clipboard, one line each, with the details of those that are faults of this "
        "program"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there are errors."""
        if not len(session_of(context).errors):
            cls.poll_message_set(tr("Nothing has failed"))
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        """Copy them."""
        errors = session_of(context).errors
        context.window_manager.clipboard = _text_of(errors)
        self.report({"INFO"}, counted("{count:,} error copied", "{count:,} errors copied", len(errors)))
        return {"FINISHED"}


register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_index_library, SHAPEGOOGLE_OT_cancel_indexing, SHAPEGOOGLE_OT_copy_errors)
)


def unregister() -> None:
    """Unregister the operators and end all runs."""
    jobs.end(state.current().library.indexing)
    _unregister()
