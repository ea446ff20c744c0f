# SPDX-License-Identifier: MIT
"""Runs inside a Blender with a window: does what the test asks for, between two redraws, and answers.

The test writes a request into a folder, `N.request` with the name of a function below and its arguments as
JSON; this one answers in `N.answer`. Real clicks come from outside; only what they lead to is read here.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
import traceback
from pathlib import Path
from typing import Any

import bpy

NAME = "bl_ext.user_default.shape_google"
CATEGORY = "Shape Google"
SECONDS_BETWEEN_LOOKS = 0.02
# In words that no button puts into the clipboard.
NOTHING = "no button"


def view() -> Any:
    """The window, the 3D view and its regions by type."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    return window, area, {region.type: region for region in area.regions}


def overridden(region_type: Any) -> Any:
    window, area, regions = view()
    return bpy.context.temp_override(window=window, area=area, region=regions[region_type])


def rectangle(region: Any) -> Any:
    """Left, top, right and bottom of a region in the picture of the window, whose rows count from above."""
    height = bpy.context.window_manager.windows[0].height
    return [region.x, height - region.y - region.height, region.x + region.width, height - region.y]


def regions() -> Any:
    """Where the sidebar and the 3D view itself are."""
    return {name.lower(): rectangle(region) for name, region in view()[2].items()}


def gallery() -> Any:
    """Where the pictures of the large gallery are, and whether it compares; None if it is not open."""
    editor = sys.modules[f"{NAME}.gallery.editor.area"]
    window = bpy.context.window_manager.windows[0]
    area = next((area for area in window.screen.areas if editor.is_gallery(area)), None)
    if area is None:
        return None
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bars, indices = editor.bars_in(bpy.context), editor.shown_indices(bpy.context)
        grid = editor.grid_in(bpy.context, bars.content, len(indices))
    boxes = [grid.picture_in(grid.cell(place, 0)) for place in range(len(indices))]
    comparison = sys.modules[f"{NAME}.state"].current().gallery.view.comparison
    return {
        "area": rectangle(region),
        "pictures": [
            [region.x + (box.left + box.right) / 2, window.height - region.y - (box.bottom + box.top) / 2]
            for box in boxes
        ],
        "compared": comparison is not None and comparison.surfaces is not None,
    }


def stands_at(name: str) -> Any:
    """Where in the window the middle of the underside of an object is seen, from the top left."""
    from bpy_extras.view3d_utils import location_3d_to_region_2d
    from mathutils import Vector

    window, area, regions = view()
    item = bpy.data.objects[name]
    corners = [item.matrix_world @ Vector(corner) for corner in item.bound_box]
    low, high = ([end(corner[axis] for corner in corners) for axis in range(3)] for end in (min, max))
    middle = Vector(((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]))
    x, y = location_3d_to_region_2d(regions["WINDOW"], area.spaces.active.region_3d, middle)
    return [regions["WINDOW"].x + x, window.height - regions["WINDOW"].y - y]


def begin_moving(old: str, new: str) -> None:
    """Open the dialog that tells the library where a folder is now."""
    with overridden("WINDOW"):
        bpy.ops.shape_google.move_sources("INVOKE_DEFAULT", old=old, new=new)


def show_sidebar() -> None:
    """Open the sidebar; its tabs are there only after it was drawn once."""
    view()[1].spaces.active.show_region_ui = True


def show_tab() -> Any:
    """Open the tab of the add-on."""
    sidebar = view()[2]["UI"]
    try:
        sidebar.active_panel_category = CATEGORY
    except TypeError:  # not drawn yet, so it has no tabs
        return False
    view()[1].tag_redraw()
    return True


def scrolled() -> Any:
    """How far the sidebar is scrolled."""
    return view()[2]["UI"].view2d.region_to_view(0, 0)[1]


DRAWS = {"UI": 0, "WINDOW": 0}
HANDLERS: list[Any] = []


def count_draws() -> Any:
    """How often the sidebar and the 3D view itself were drawn since the last call; the first one begins."""
    if not HANDLERS:
        for name in DRAWS:
            HANDLERS.append(bpy.types.SpaceView3D.draw_handler_add(_note_draw, (name,), name, "POST_PIXEL"))
    counted = dict(DRAWS)
    DRAWS.update(dict.fromkeys(DRAWS, 0))
    return counted


def _note_draw(region_type: str) -> None:
    DRAWS[region_type] += 1


def view_direction() -> Any:
    """How the 3D view is turned."""
    return list(view()[1].spaces.active.region_3d.view_rotation)


class DRIVER_OT_note_pointer(bpy.types.Operator):
    """Blender says where the pointer is only to an operator that is invoked."""

    bl_idname = "driver.note_pointer"
    bl_label = "Note Pointer"
    place = (-1, -1)

    def invoke(self, _context: Any, event: Any) -> set[str]:
        """Remember where the pointer was in the last event that Blender handled."""
        type(self).place = event.mouse_x, event.mouse_y
        return {"FINISHED"}


def pointer() -> Any:
    """Where the pointer is as far as Blender has noticed, from the top left."""
    with overridden("UI"):
        bpy.ops.driver.note_pointer("INVOKE_DEFAULT")
    x, y = DRIVER_OT_note_pointer.place
    return [x, bpy.context.window_manager.windows[0].height - 1 - y]


def button() -> Any:
    """What the button under the pointer does, as Blender copies it: a command, or the path of a property."""
    manager = bpy.context.window_manager
    with overridden("UI"):
        for copy in (bpy.ops.ui.copy_python_command_button, bpy.ops.ui.copy_data_path_button):
            if copy.poll():
                manager.clipboard = NOTHING
                copy()
                if manager.clipboard != NOTHING:
                    return manager.clipboard
    return None


def empty_clipboard() -> None:
    """Put what no button does into the clipboard."""
    bpy.context.window_manager.clipboard = NOTHING


def clipboard() -> Any:
    """What is in the clipboard."""
    return bpy.context.window_manager.clipboard


def state() -> Any:
    """All that the add-on shows, and what is in the scene."""
    manager = bpy.context.window_manager
    session, duplicates = manager.shape_google, manager.shape_google_duplicates
    return {
        "session": {
            name: getattr(session, name)
            for name in (
                "indexing",
                "done",
                "total",
                "progress",
                "summary",
                "shape_count",
                "searching",
                "query",
                "answer",
                "active_match",
            )
        },
        "errors": [[error.path, error.reason] for error in session.errors],
        "matches": [
            {name: getattr(match, name) for name in ("name", "object_name", "source", "similarity", "kind")}
            for match in session.matches
        ],
        "duplicates": {
            "running": duplicates.running,
            "status": duplicates.status,
            "groups": [
                {"kind": group.kind, "chosen": group.chosen, "members": [line.name for line in group.members]}
                for group in duplicates.groups
            ],
        },
        "painting": {
            name: getattr(bpy.context.scene.shape_google_painting, name) for name in ("kind", "scale")
        },
        "objects": {
            item.name: {
                "data": item.data.name if item.data else None,
                "selected": item.select_get(),
                "attributes": sorted(
                    attribute.name
                    for attribute in (item.data.attributes if item.type == "MESH" else ())
                    if attribute.name.startswith("sg_")
                ),
                "visible": item.visible_get(),
                "groups": [group.name for group in item.vertex_groups],
                "colors": [layer.name for layer in item.data.color_attributes] if item.type == "MESH" else [],
            }
            for item in bpy.context.scene.objects
        },
        "active": getattr(bpy.context.view_layer.objects.active, "name", None),
        "file": bpy.data.filepath,
        "transferring": bpy.ops.shape_google.cancel_transfer.poll(),
    }


def word_colors(name: str) -> Any:
    """The word and the colour of every vertex of an object."""
    mesh = bpy.data.objects[name].data
    words = [item.value for item in mesh.attributes["sg_word"].data]
    colors = [[round(value, 4) for value in item.color[:3]] for item in mesh.attributes["sg_color"].data]
    return [words, colors]


def colors(name: str) -> Any:
    """The colour of every vertex of an object."""
    mesh = bpy.data.objects[name].data
    return [[round(value, 4) for value in item.color[:3]] for item in mesh.attributes["sg_color"].data]


def weights(name: str, group: Any) -> Any:
    """The weight of every vertex of an object in a group; 0 for those that are not in it."""
    item = bpy.data.objects[name]
    index = item.vertex_groups[group].index
    return [
        sum(entry.weight for entry in vertex.groups if entry.group == index) for vertex in item.data.vertices
    ]


def add_object(path: Path, name: str, location: Any = (0, 0, 0)) -> None:
    """Import a mesh file, as File > Import does, as the only selected object."""
    with overridden("WINDOW"):
        bpy.ops.wm.ply_import(filepath=path)
        item = bpy.context.view_layer.objects.active
        item.name = item.data.name = name
        item.location = location
        bpy.ops.ed.undo_push(message="Import")


def look(turn: Any = 0.5) -> None:
    """Show the whole scene from before, turned by an angle, and a little from above."""
    with overridden("WINDOW"):
        bpy.context.view_layer.update()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_orbit(angle=turn, type="ORBITLEFT")
        bpy.ops.view3d.view_orbit(angle=0.35, type="ORBITUP")
        bpy.ops.view3d.view_all()
        # The sidebar is above the right part of the view.
        bpy.ops.view3d.zoom(delta=-1, use_cursor_init=False)
        bpy.ops.view3d.view_pan(type="PANRIGHT")


def empty_scene() -> None:
    """Remove what a new file holds."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)


def run(code: Any) -> Any:
    """Run code, for what no click can set."""
    scope = {"bpy": bpy, "name": NAME, "preferences": bpy.context.preferences.addons[NAME].preferences}
    exec(code, scope)
    view()[1].tag_redraw()
    return scope.get("result")


def hold_worker() -> Any:
    """Stop the process that computes where it is, for as long as a test needs; false if there is none."""
    return _signal_worker(signal.SIGSTOP)


def release_worker() -> Any:
    """Let it go on."""
    return _signal_worker(signal.SIGCONT)


def _signal_worker(number: Any) -> Any:
    process = sys.modules[f"{NAME}.jobs"].worker()._process
    if process is None or process.poll() is not None:
        return False
    process.send_signal(number)
    return True


def quit_blender() -> None:
    """End without a question for unsaved changes, and leave no temporary files behind."""

    def end() -> None:
        shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
        os._exit(0)

    bpy.app.timers.register(end, first_interval=0.2)


def answer(folder: Path) -> Any:
    """Do what was asked since the last look."""
    for path in sorted(folder.glob("*.request")):
        name, arguments = json.loads(path.read_text())
        path.unlink()
        try:
            content = {"result": globals()[name](*arguments)}
        except Exception:
            content = {"error": traceback.format_exc()}
        written = path.with_suffix(".written")
        written.write_text(json.dumps(content))
        written.rename(path.with_suffix(".answer"))
    return SECONDS_BETWEEN_LOOKS


if __name__ == "__main__":
    bpy.utils.register_class(DRIVER_OT_note_pointer)
    FOLDER = Path(sys.argv[sys.argv.index("--") + 1])
    bpy.app.timers.register(lambda: answer(FOLDER), persistent=True)
