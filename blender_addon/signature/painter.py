# SPDX-License-Identifier: GPL-3.0-or-later
"""`Painter`: computing and painting objects, as the operators that paint have in common."""

from __future__ import annotations

import traceback
from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, Any

from .. import jobs
from ..library.model import current_model
from ..time_slices import next_slice, result_of
from ..translation import counted, error_text, tr
from . import shading
from .choices import TIMED, Painting
from .distance import scale_text
from .picked import picked
from .properties import settings_of

if TYPE_CHECKING:
    from concurrent.futures import Future

    from .results import Known, Task

__all__ = ["MODES", "Painter"]

# Longer computations run in the worker process, so that the window stays usable.
MOST_SECONDS = 0.15
SECONDS_BETWEEN_LOOKS = 0.02
# Vertices from which on reading a mesh takes long.
LARGE = 50_000
MODES = {"OBJECT", "EDIT_MESH"}


class Painter:
    """Base of the operators that paint; long computations run in the worker process."""

    def paint_in_background(self, context: Any, objects: Sequence[Any]) -> set[str]:
        """Paint objects, at once if it is quick; else the window stays usable meanwhile."""
        self._failed: list[str] = []
        self._names = [item.name for item in objects]
        self._waiting: list[tuple[Task, Future[Any]]] = []
        self._timer: Any = None
        self._reading: Generator[bool, None, None] | None = self._keep_tasks(context, objects)
        if not next_slice(self._reading):
            return self._compute(context)
        self._begin_waiting(context, self._names[0])
        return {"RUNNING_MODAL"}

    def _keep_tasks(self, context: Any, objects: Sequence[Any]) -> Generator[bool, None, None]:
        self._tasks: list[Task] | None = yield from self._task_steps(context, objects)

    def _begin_waiting(self, context: Any, name: str) -> None:
        """Look now and then from now on, unless it is done already, and say what is computed."""
        if self._timer is None:
            manager = context.window_manager
            self._timer = manager.event_timer_add(SECONDS_BETWEEN_LOOKS, window=context.window)
            manager.modal_handler_add(self)
        context.workspace.status_text_set(_computing(name))

    def _compute(self, context: Any) -> set[str]:
        """Compute what has been read, and paint if that is quick."""
        self._reading = None
        tasks = self._tasks
        if tasks is None:
            self.cancel(context)
            return self._give_up(context)
        if sum(task.seconds for task in tasks) < MOST_SECONDS:
            self.cancel(context)
            return self._paint_now(context, self._objects(context), tasks)
        self._waiting = [(task, jobs.worker().submit(task.function, *task.arguments)) for task in tasks]
        self._begin_waiting(context, tasks[0].name)
        return {"RUNNING_MODAL"}

    def _objects(self, context: Any) -> list[Any]:
        """Return the objects that are still there."""
        present = context.view_layer.objects
        return [present[name] for name in self._names if name in present]

    def paint_at_once(self, context: Any, objects: Sequence[Any]) -> set[str]:
        """Paint objects before returning."""
        self._failed = []
        tasks = result_of(self._task_steps(context, objects))
        return self._give_up(context) if tasks is None else self._paint_now(context, objects, tasks)

    def lacking(self, items: Sequence[Any]) -> str:  # noqa: ARG002
        """Return why it is not enough to paint these objects, all that can be painted; empty if it is."""
        return ""

    def take_back(self, context: Any) -> None:
        """Undo the preparations of a painting that fails or is cancelled."""

    def modal(self, context: Any, event: Any) -> set[str]:
        """Wait for the worker; the window stays usable."""
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"INFO"}, tr("Painting cancelled"))  # type: ignore[attr-defined]
            return self._give_up(context)
        if self._reading is not None:
            # As long as objects are read, they must not change.
            done = event.type == "TIMER" and not next_slice(self._reading)
            return self._compute(context) if done else {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        while self._waiting and self._waiting[0][1].done():
            task, future = self._waiting.pop(0)
            self._finish(task, future.result)
            if self._waiting:
                context.workspace.status_text_set(_computing(self._waiting[0][0].name))
        if self._waiting or context.mode not in MODES:  # painting waits while the user sculpts
            return {"PASS_THROUGH"}
        self.cancel(context)
        return self._paint(context, self._objects(context))

    def cancel(self, context: Any) -> None:
        """Stop waiting and cancel the tasks."""
        for _, future in self._waiting:
            future.cancel()
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            context.workspace.status_text_set(None)
            self._timer = None

    def _paint_now(self, context: Any, objects: Sequence[Any], tasks: Sequence[Task]) -> set[str]:
        for task in tasks:
            self._finish(task, lambda task=task: task.function(*task.arguments))
        return self._paint(context, objects)

    def _give_up(self, context: Any, reason: str = "") -> set[str]:
        self.take_back(context)
        if reason:
            self.report({"ERROR"}, reason)  # type: ignore[attr-defined]
        return {"CANCELLED"}

    def _finish(self, task: Task, result: Any) -> None:
        from shapegoogle_core import MeshError, ShapeGoogleError

        from .results import remember

        try:
            remember(task, result())
        except MeshError as error:
            self._failed.append(error_text(error))
        except ShapeGoogleError as error:  # such as a worker process that ran out of memory and was killed
            text = tr("{name!r} could not be computed: {reason}")
            self._failed.append(text.format(name=task.name, reason=error_text(error)))
        except Exception:
            traceback.print_exc()
            text = tr(
                "{name!r} could not be computed because of a fault in Shape Google; report it with the last "
                "lines of the console"
            )
            self._failed.append(text.format(name=task.name))

    def _task_steps(self, context: Any, objects: Sequence[Any]) -> Generator[bool, None, list[Task] | None]:
        """Find the computations that are needed; None, after a report, if nothing can be computed."""
        from shapegoogle_core import MeshError, ShapeGoogleError

        from . import painting, results

        chosen = settings_of(context.scene)
        try:
            model = current_model(context) if chosen.kind == "WORDS" else None
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))  # type: ignore[attr-defined]
            return None
        tasks = []
        for item in painting.targets(objects)[0]:
            is_large = len(item.data.vertices) >= LARGE
            key = results.key_of(item, chosen, model)
            yield is_large
            if results.known(key) is None:
                try:
                    tasks.append(results.task_of(item, chosen, model, key))
                except MeshError as error:
                    self._failed.append(error_text(error))
                yield is_large
        return tasks

    def _paint(self, context: Any, objects: Any) -> set[str]:
        from shapegoogle_core import MeshError

        from . import painting, results

        chosen = settings_of(context.scene)
        settings = context.scene.shape_google_painting
        color, keep = settings.color, settings.keep
        model = current_model(context) if chosen.kind == "WORDS" else None
        items, refused = painting.targets(objects)
        self._failed += refused
        known = [(item, results.known(results.key_of(item, chosen, model))) for item in items]
        # One without an entry has failed before, or was changed since.
        lacking = self.lacking([item for item, entry in known if entry is not None])
        done = []
        for item, entry in known:
            if entry is None or lacking:
                continue
            try:
                painting.apply(item, chosen, entry, color=color, keep=keep)
            except MeshError as error:
                self._failed.append(error_text(error))
            else:
                done.append((item, entry))
        for reason in self._failed if done or lacking else self._failed[:-1]:
            self.report({"WARNING"}, reason)  # type: ignore[attr-defined]
        if not done:
            failed = self._failed[-1] if self._failed else tr("The objects were changed; paint again")
            return self._give_up(context, lacking or failed)
        if color:
            shading.show_colors(context)
        summary = _summary(chosen, done, context.scene.unit_settings)
        self.report({"INFO"}, summary)  # type: ignore[attr-defined]
        return {"FINISHED"}


def _computing(name: str) -> str:
    return tr("Computing {name} … (Esc: cancel)").format(name=name)


def _summary(chosen: Painting, done: list[tuple[Any, Known]], units: Any) -> str:
    from shapegoogle_core import VertexKeypoints, VertexSpectrum, VertexWords

    objects = repr(done[0][0].name)
    if len(done) > 1:
        objects = counted("{count:,} object", "{count:,} objects", len(done))
    results = [entry.result for _, entry in done]
    if isinstance(results[0], VertexWords):
        text = tr("Painted {objects}: {count} words of {channel}")
        return text.format(objects=objects, count=len(results[0].bag), channel=chosen.channel)
    text = _painted(chosen, done, objects, units)
    if any(isinstance(result, (VertexSpectrum, VertexKeypoints)) and result.simplified for result in results):
        copy = tr("{summary}, computed on a copy of {count:,} vertices")
        return copy.format(summary=text, count=chosen.budget)
    return text


def _painted(chosen: Painting, done: list[tuple[Any, Known]], objects: str, units: Any) -> str:
    from shapegoogle_core import VertexKeypoints

    if chosen.kind == "KEYPOINTS":
        count = sum(len(entry.result) for _, entry in done if isinstance(entry.result, VertexKeypoints))
        return counted(
            "Painted {objects}: {count} keypoint of {detector}",
            "Painted {objects}: {count} keypoints of {detector}",
            count,
            objects=objects,
            detector=chosen.detector,
        )
    if len(done) == 1 and chosen.kind in TIMED:
        item = done[0][0]
        place = scale_text(item, chosen, units)
        vertex = picked(item) if chosen.kind == "HEAT" else None
        if vertex is None:
            return tr("Painted {objects} at {distance}").format(objects=objects, distance=place)
        text = tr("Painted {objects} from {vertex}, at {distance}")
        return text.format(objects=objects, vertex=vertex, distance=place)
    return tr("Painted {objects}").format(objects=objects)
