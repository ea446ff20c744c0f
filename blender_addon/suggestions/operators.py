# SPDX-License-Identifier: GPL-3.0-or-later
"""Suggest tags and catalogs of an object, show them with their confidence, and write the chosen ones."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import bpy

from .. import connections, jobs
from ..library.address import library_address, library_missing
from ..library.open_file import open_source
from ..needs import draw_sentence
from ..reading.assets import CATALOG_FILE, catalogs_for, tags_of
from ..scene.reads_meshes import ReadsMeshes
from ..scene.selection import query_objects
from ..state import session_of
from ..translation import error_text, tr

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core import Mesh, MeshError, Suggestion

__all__ = ["known_catalogs", "register", "unregister"]

# Suggestions that are shown, at least this confident; those that are rather right than wrong are chosen.
MOST_SHOWN = 10
LEAST_CONFIDENCE = 0.1
CHOSEN_FROM = 0.5
# Of the dialog: its width, and the longest line in it.
WIDTH, LETTERS = 360, 48


class SHAPEGOOGLE_OT_suggest_tags(ReadsMeshes, bpy.types.Operator):
    """Suggest tags and catalogs."""

    bl_idname = "shape_google.suggest_tags"
    bl_label = "Suggest Tags…"
    bl_description = (
        "Show the tags and catalogs that the nearest shapes of the library have; those that you choose are "
        "written to the active object, which becomes an asset"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is an object that can be an asset, and a library."""
        item = context.active_object
        if item is None or not query_objects([item]) or context.mode != "OBJECT":
            cls.poll_message_set(tr("Select an object, in object mode"))
            return False
        if item.library is not None:
            cls.poll_message_set(tr("The object belongs to another file; open that"))
            return False
        if session_of(context).suggesting:
            cls.poll_message_set(tr("Suggestions are already being made"))
            return False
        missing = library_missing(context)
        if missing:
            cls.poll_message_set(missing)
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask the worker process, then show a dialog."""
        from ..scene.query import object_steps

        item = context.active_object
        self._name, self._uid = item.name, item.session_uid
        self._window, self._area = context.window, context.area
        self._notes: list[str] = []
        return self.read_meshes(context, object_steps(item, context, self._notes))

    def begin(self, context: Any, steps: Iterator[object]) -> set[str]:
        """Go on reading in slices."""
        session_of(context).suggesting = True
        return super().begin(context, steps)

    def show_progress(self, context: Any) -> None:
        """Say that the object is being read."""
        text = tr("Reading {name} …").format(name=self._name)
        context.workspace.status_text_set(tr("{progress} (Esc: cancel)").format(progress=text))

    def cancel(self, context: Any) -> None:
        """Stop the timer and free the button."""
        super().cancel(context)
        session_of(context).suggesting = False

    def take_meshes(self, context: Any, found: Mesh) -> set[str]:
        """Show a dialog once the worker has found suggestions."""
        name, uid, window, area = self._name, self._uid, self._window, self._area
        for note in self._notes:
            self.report({"WARNING"}, note)
        session_of(context).suggesting = True

        def done(suggestions: list[Suggestion]) -> None:
            session_of(bpy.context).suggesting = False
            _fill(bpy.context, uid, suggestions)
            region = next((region for region in area.regions if region.type == "WINDOW"), None)
            with bpy.context.temp_override(window=window, area=area, region=region):
                bpy.ops.shape_google.write_suggestions("INVOKE_DEFAULT")

        def failed(error: BaseException) -> None:
            session = session_of(bpy.context)
            session.suggesting = False
            session.answer = f"{name}: {error_text(error)}"

        jobs.watch(_ask(context, found, name), done, failed)
        return {"FINISHED"}

    def take_error(self, _context: Any, error: MeshError) -> set[str]:
        """Report it."""
        self.report({"ERROR"}, error_text(error))
        return {"CANCELLED"}

    def take_cancelled(self, _context: Any) -> set[str]:
        """Do nothing."""
        return {"CANCELLED"}

    def execute(self, context: Any) -> set[str]:
        """Wait for the suggestions; `write_suggestions` writes them."""
        from shapegoogle_core import ShapeGoogleError

        from ..scene.query import object_mesh

        item = context.active_object
        try:
            found = _ask(context, object_mesh(item, context), item.name).result()
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        _fill(context, item.session_uid, found)
        return {"FINISHED"}


def _ask(context: Any, mesh: Mesh, name: str) -> Future[list[Suggestion]]:
    """Have the worker find suggestions for an object of the open file."""
    from shapegoogle_core.worker.assets import suggest

    return jobs.worker().submit(suggest, library_address(context), mesh, open_source(), name)


def _fill(context: Any, uid: int, found: list[Suggestion]) -> None:
    """Put suggestions that are new to an object into the session."""
    session = session_of(context)
    session.suggestions.clear()
    session.suggested_for = uid
    item = _object_of(uid)
    own = set() if item is None else set(tags_of(item))
    catalogs = known_catalogs()
    has_catalog = False
    for suggestion in found:
        if suggestion.confidence < LEAST_CONFIDENCE or len(session.suggestions) == MOST_SHOWN:
            break
        if suggestion.kind == "tag" and suggestion.text in own:
            continue
        if suggestion.kind == "catalog" and suggestion.text not in catalogs:
            continue
        line = session.suggestions.add()
        line.kind, line.text = suggestion.kind, suggestion.text
        line.confidence = suggestion.confidence
        line.relatives = ", ".join(suggestion.relatives[:3])
        line.use = suggestion.confidence >= CHOSEN_FROM and not (suggestion.kind == "catalog" and has_catalog)
        has_catalog = has_catalog or suggestion.kind == "catalog"


def known_catalogs() -> dict[str, str]:
    """Return the catalogs that an asset of the open file can be in.

    Returns
    -------
    catalogs : dict of str to str
        Identifiers by path: those of the asset library that the file lies in, then of the others in
        Blender's preferences.
    """
    files = [Path(bpy.data.filepath)] if bpy.data.filepath else []
    files += [folder / CATALOG_FILE for _, folder in connections.asset_libraries()]
    found: dict[str, str] = {}
    for path in files:
        for identifier, catalog in catalogs_for(path).items():
            found.setdefault(catalog, identifier)
    return found


def _object_of(uid: int) -> Any | None:
    return next((item for item in bpy.data.objects if item.session_uid == uid), None)


def _gone() -> str:
    return tr("The object is gone; select another one and suggest again")


def _draw_nothing(menu: Any, _context: Any) -> None:
    for text in (
        tr("The nearest shapes have no further tags or catalogs."),
        tr("Tag some assets, index them, and try again."),
    ):
        menu.layout.label(text=text, translate=False)


class SHAPEGOOGLE_OT_write_suggestions(bpy.types.Operator):
    """Write the chosen suggestions."""

    bl_idname = "shape_google.write_suggestions"
    bl_label = "Write Tags and Catalog"
    bl_description = "Write the chosen tags and the catalog to the asset"
    bl_options: ClassVar = {"UNDO", "INTERNAL"}

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Show the suggestions, and write after confirmation; where there are none, say so."""
        session = session_of(context)
        if not len(session.suggestions) and _object_of(session.suggested_for) is not None:
            context.window_manager.popup_menu(_draw_nothing, title=tr("Nothing to Suggest"), icon="INFO")
            return {"CANCELLED"}
        result: set[str] = context.window_manager.invoke_props_dialog(
            self, width=WIDTH, confirm_text=tr("Write")
        )
        return result

    def draw(self, context: Any) -> None:
        """Lay the suggestions out."""
        session = session_of(context)
        item = _object_of(session.suggested_for)
        column = self.layout.column()
        if item is None:
            draw_sentence(column, _gone(), letters=LETTERS, icon="ERROR")
            return
        text = tr("{name}: what the nearest shapes have")
        column.label(text=text.format(name=item.name), translate=False)
        for line in session.suggestions:
            split = column.split(factor=0.55)
            row = split.row()
            row.label(text="", icon="BOOKMARKS" if line.kind == "tag" else "ASSET_MANAGER")
            # A box to check: a button that is pressed looks like a bar of the percentage beside it.
            row.prop(line, "use", text=line.text, translate=False)
            split.label(text=f"{line.confidence:.0%}  {line.relatives}", translate=False)
        if item.asset_data is None:
            column.label(text="The object becomes an asset.", icon="INFO")

    def execute(self, context: Any) -> set[str]:
        """Write them."""
        session = session_of(context)
        item = _object_of(session.suggested_for)
        chosen = [line for line in session.suggestions if line.use]
        if item is None:
            self.report({"ERROR"}, _gone())
            return {"CANCELLED"}
        if not chosen:
            self.report({"INFO"}, tr("Nothing was chosen, and nothing is written"))
            return {"CANCELLED"}
        if item.asset_data is None:
            item.asset_mark()
        tags = [line.text for line in chosen if line.kind == "tag"]
        for tag in tags:
            item.asset_data.tags.new(tag, skip_if_exists=True)
        catalog = next((line.text for line in chosen if line.kind == "catalog"), "")
        if catalog:
            item.asset_data.catalog_id = known_catalogs()[catalog]
        if tags and catalog:
            text = tr("{name} has the tags {tags} and the catalog {catalog} now")
        elif tags:
            text = tr("{name} has the tags {tags} now")
        else:
            text = tr("{name} has the catalog {catalog} now")
        self.report({"INFO"}, text.format(name=item.name, tags=", ".join(tags), catalog=catalog))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_suggest_tags, SHAPEGOOGLE_OT_write_suggestions)
)
