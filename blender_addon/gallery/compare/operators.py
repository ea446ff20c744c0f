# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare the chosen match with the query: ask the worker, show both in the gallery, turn them."""

from __future__ import annotations

from collections.abc import Generator
from functools import partial
from typing import TYPE_CHECKING, Any

import bpy

from ... import jobs, state
from ...scene.reads_meshes import ReadsMeshes
from ...state import session_of
from ...time_slices import result_of
from ...translation import error_text, tr
from .. import finding, labels
from ..editor import area
from ..editor.operators import InGallery
from ..errors import PlacingError
from ..on_match import OnMatch, active_match
from .shown import Shown
from .turning import turned

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core import Match, Mesh
    from shapegoogle_core.worker.comparison import SurfaceComparison
    from shapegoogle_core.worker.requests import Answer

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_OT_compare_match(OnMatch, ReadsMeshes, bpy.types.Operator):
    """Compare the match with the query."""

    bl_idname = "shape_google.compare_match"
    bl_label = "Compare"
    bl_description = (
        "Show the query and the match side by side in the gallery, turning together, with the distance "
        "between their surfaces in color"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a match of the answer shown."""
        if not super().poll(context):
            return False
        if _asked(context) is None:
            cls.poll_message_set(tr("Find similar shapes first"))
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Open the gallery, and show both once the worker has compared them."""
        if area.open_beside(context) is None:
            self.report(
                {"ERROR"},
                tr(
                    "There is no 3D view with room for the gallery; choose Shape Gallery in the editor menu "
                    "of an area"
                ),
            )
            return {"CANCELLED"}
        match = active_match(context)
        self._shown = Shown(session_of(context).query, labels.title(match), match.shape_id)
        state.current().gallery.view.comparison = self._shown
        area.redraw(context)
        # Before the mesh is read: another match may be chosen meanwhile.
        self._asked_for = _asked(context)
        return self.read_meshes(context, _steps_here(context, match))

    def show_progress(self, context: Any) -> None:
        """Say that the match is being read."""
        text = tr("Reading {name} …").format(name=self._shown.match)
        context.workspace.status_text_set(tr("{progress} (Esc: cancel)").format(progress=text))

    def take_meshes(self, _context: Any, found: Mesh | None) -> set[str]:
        """Show both once the worker has compared them."""
        shown = self._shown

        def done(surfaces: SurfaceComparison) -> None:
            shown.surfaces = surfaces

        def failed(error: BaseException) -> None:
            shown.problem = error_text(error)

        jobs.watch(_submit(self._asked_for, found), done, failed)
        return {"FINISHED"}

    def take_cancelled(self, context: Any) -> set[str]:
        """Say so in place of the shapes."""
        self._shown.problem = tr("Cancelled")
        area.redraw(context)
        return {"CANCELLED"}

    def execute(self, context: Any) -> set[str]:
        """Compare them, and report how far apart they are."""
        from shapegoogle_core import ShapeGoogleError

        try:
            mesh = result_of(_steps_here(context, active_match(context)))
            surfaces = _submit(_asked(context), mesh).result()
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        text = tr("{name}: median distance {median}, 95 % of the surface within {most}, size ×{factor:.3g}")
        self.report(
            {"INFO"},
            text.format(
                name=labels.title(active_match(context)),
                median=length_text(context, surfaces.typical),
                most=length_text(context, surfaces.most),
                factor=active_match(context).size,
            ),
        )
        return {"FINISHED"}


def _asked(context: Any) -> tuple[Answer, Match] | None:
    """Return the answer that the chosen match is of, and what the search has found out about it."""
    session, search = session_of(context), state.current().search
    answer = search.versions if session.opened >= 0 else search.answer
    line = active_match(context)
    if answer is None or line is None:
        return None
    found = [match for match in answer.matches if match.shape_id == line.shape_id]
    return (answer, search.explained.get(line.shape_id, found[0])) if found else None


def _submit(asked: tuple[Answer, Match] | None, mesh: Mesh | None) -> Future[SurfaceComparison]:
    """Have the worker compare the surfaces."""
    from shapegoogle_core.worker.comparison import compare_surfaces

    assert asked is not None  # see poll
    answer, match = asked
    examples = state.current().search.asked_with
    compare = partial(compare_surfaces, queries=examples.meshes, stored=examples.stored)
    return jobs.worker().submit(compare, answer.library, answer.signatures, match, mesh)


def _steps_here(context: Any, match: Any) -> Generator[bool, None, Mesh | None]:
    """Read a match in the open scene; None for others, of which the worker knows the file or a preview."""
    from shapegoogle_core import MeshError

    from ...scene.query import object_steps

    vertex_count = match.vertex_count
    try:
        here = finding.object_of(context, match)
        if here is None or match.shape_type == "collection":
            return None
        mesh = yield from object_steps(here, context)
    except (PlacingError, MeshError):  # it is gone; the library still has its preview
        return None
    return mesh if len(mesh.vertices) == vertex_count else None


def length_text(context: Any, value: float) -> str:
    """Write a length in the units of the scene.

    Parameters
    ----------
    context : bpy.types.Context
    value : float
        In Blender's units.

    Returns
    -------
    text : str
        With three digits.
    """
    units = context.scene.unit_settings
    if units.system == "NONE":
        return f"{value:.3g}"
    scaled = value * units.scale_length
    return str(bpy.utils.units.to_string(units.system, "LENGTH", scaled, precision=3))


class SHAPEGOOGLE_OT_gallery_turn(InGallery, bpy.types.Operator):
    """Turn the query and the match together."""

    bl_idname = "shape_google.gallery_turn"
    bl_label = "Turn Shapes"
    bl_description = "Turn the query and the match together"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that two surfaces are shown."""
        return super().poll(context) and state.current().gallery.view.comparison is not None

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Turn as long as the button is held down."""
        self._button, self._at = event.type, (event.mouse_x, event.mouse_y)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Follow the pointer."""
        shown = state.current().gallery.view.comparison
        if shown is None or (event.type == self._button and event.value == "RELEASE") or event.type == "ESC":
            return {"FINISHED"}
        if event.type in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE"):
            scale = context.preferences.system.ui_scale
            x, y = self._at
            right, up = (event.mouse_x - x) / scale, (event.mouse_y - y) / scale
            shown.direction = turned(shown.direction, right, up)
            self._at = event.mouse_x, event.mouse_y
            area.redraw(context)
        return {"RUNNING_MODAL"}


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_compare_match, SHAPEGOOGLE_OT_gallery_turn)
)
