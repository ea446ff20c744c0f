# SPDX-License-Identifier: GPL-3.0-or-later
"""Train a model on the shapes of the library's sources."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from .. import jobs, state
from ..jobs import BackgroundRun, redraw
from ..preferences import preferences
from ..state import session_of
from ..translation import tr
from .properties import add_error
from .sentences import step_text

__all__ = ["register", "unregister"]

SECONDS_BETWEEN_LOOKS = 0.5


class SHAPEGOOGLE_OT_train_model(bpy.types.Operator):
    """Train a model on the shapes of the library's sources."""

    bl_idname = "shape_google.train_model"
    bl_label = "Train Model on This Library"
    bl_description = (
        "Train words, metric and codes on the shapes of the chosen sources, in the background: about a "
        "second for each shape and version. The model is for new libraries; this one keeps its own"
    )

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.npz", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there are sources to train on."""
        if not preferences(context).has_sources():
            cls.poll_message_set(tr("Add a folder, or an asset library in Blender's preferences"))
            return False
        return not session_of(context).training

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask where to put it."""
        self.filepath = str(preferences(context).libraries_folder() / "mine.npz")
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Any) -> set[str]:
        """Train, in the background where there is a window."""
        chosen = preferences(context)
        path = Path(bpy.path.abspath(self.filepath))
        path = path if path.suffix == ".npz" else path.with_name(f"{path.name}.npz")
        preset = "paper" if chosen.model == "PAPER" else "default"
        arguments = ["train", *map(str, chosen.sources()), "--output", str(path), "--preset", preset]
        arguments += ["--objects", chosen.objects.lower()]
        if chosen.jobs:
            arguments += ["--jobs", str(chosen.jobs)]
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            run = BackgroundRun(arguments)
        except OSError as error:
            text = tr("{path}: {reason}; choose another place")
            self.report({"ERROR"}, text.format(path=path, reason=error.strerror))
            return {"CANCELLED"}
        state.current().library.training = run
        session_of(context).training = tr("Training …")
        if bpy.app.background:
            run.join()
            _take(run, path)
            self.report({"INFO"}, session_of(context).trained)
        else:
            look = partial(_look, run, path)
            bpy.app.timers.register(look, first_interval=SECONDS_BETWEEN_LOOKS, persistent=True)
        return {"FINISHED"}


def _look(run: BackgroundRun, path: Path) -> float | None:
    if not state.is_registered() or state.current().library.training is not run:  # cancelled
        return None
    _take(run, path)
    redraw()
    return SECONDS_BETWEEN_LOOKS if state.current().library.training is run else None


def _take(run: BackgroundRun, path: Path) -> None:
    """Show the progress of training, and its end."""
    from shapegoogle_core.cli.events import StepProgress

    session = session_of(bpy.context)
    for event in run.events():
        if isinstance(event, StepProgress):
            session.training = step_text(event)
    if run.exit_code is None:
        return
    state.current().library.training = None
    session.training = ""
    if path.exists() and run.exit_code in (0, 1):
        chosen = preferences()
        chosen.model, chosen.model_file = "FILE", str(path)
        session.trained = tr("Trained {name}; it is used for new libraries").format(name=path.name)
    else:
        session.trained = tr("Training failed; see the list of what was not indexed")
        add_error(session, str(path), run.last_words())


class SHAPEGOOGLE_OT_cancel_training(bpy.types.Operator):
    """Stop training."""

    bl_idname = "shape_google.cancel_training"
    bl_label = "Cancel Training"
    bl_description = "Stop training; no model is written"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a model is being trained."""
        return bool(session_of(context).training)

    def execute(self, context: Any) -> set[str]:
        """Stop it."""
        _end_training()
        session = session_of(context)
        session.training, session.trained = "", tr("Training cancelled")
        return {"FINISHED"}


def _end_training() -> None:
    training = state.current().library.training
    if training is not None:
        jobs.end([training])
        state.current().library.training = None


register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_train_model, SHAPEGOOGLE_OT_cancel_training)
)


def unregister() -> None:
    """Unregister the operators and end the run."""
    _end_training()
    _unregister()
