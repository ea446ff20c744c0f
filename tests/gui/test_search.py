# SPDX-License-Identifier: MIT
"""Indexing and searching in Blender's window: press buttons, look at what comes of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.gui.conftest import CREATURES, NAME, SHAPES
from tests.gui.window import LAST, colorful


def blue(image: Any) -> Any:
    """Share of the pixels of a picture in the blue of progress bars and of what is chosen."""
    pixels = np.asarray(image, np.int16)
    return float((pixels[..., 2] - pixels[..., 0] > 45).mean())


def horses(state: Any) -> Any:
    return [match["object_name"] for match in state["matches"][: len(CREATURES["horse"])]]


def test_index_library_goes_on_beside_a_usable_window(window: Any, indexed: Any) -> None:
    state = indexed["state"]
    # Opened where there was no library; they close with a new session, not under the pointer.
    assert window.run("result = bpy.context.window_manager.shape_google.show_sources")
    assert state["session"]["shape_count"] == SHAPES
    assert state["session"]["done"] == state["session"]["total"] == len(CREATURES) + 1
    assert len(indexed["seen"]) > 1
    for done, text in indexed["seen"].items():
        assert text.startswith(f"{done} of ")
        assert "left" in text or (done == len(CREATURES) + 1 and text.endswith(", done"))
    assert blue(indexed["bar"]) > 0.05 > blue(indexed["button"])
    assert indexed["turned"], "indexing had ended before the view was turned"
    # A scene of millions of faces must not be drawn several times in a second.
    assert indexed["draws"]["WINDOW"] < indexed["draws"]["UI"] / 3, indexed["draws"]


def test_a_file_that_cannot_be_read_is_listed_and_why(window: Any, indexed: Any, shapes: Any) -> None:
    ((path, reason),) = indexed["state"]["errors"]
    assert Path(path) == shapes / "unicorn.blend"
    assert "unicorn.blend" in reason
    window.open("Library")
    window.run("bpy.context.window_manager.shape_google.show_errors = True")
    before = window.picture("ui")
    window.run("bpy.context.window_manager.shape_google.active_error = -1")
    # The sentence is below the list for as long as its line is chosen.
    assert before.tobytes() != window.picture("ui").tobytes()
    window.run("bpy.context.window_manager.shape_google.active_error = 0")
    window.press("shape_google.copy_errors", columns=LAST)
    window.settle()
    assert reason in window.run("result = bpy.context.window_manager.clipboard")
    window.run("bpy.context.window_manager.shape_google.show_errors = False")


def test_find_similar_fills_the_gallery(window: Any, found: Any) -> None:
    assert len(found["matches"]) == SHAPES
    assert all(name.startswith("Horse") for name in horses(found))
    assert found["session"]["active_match"] == 0
    x, y = window.find("shape_google.choose_match")
    # The picture is above its name, as wide as it is high.
    above = np.asarray(window.picture((round(x) - 30, round(y) - 90, round(x) + 30, round(y) - 20)), float)
    assert above.std() > 15
    window.run("bpy.context.window_manager.shape_google.least_similarity = 1.0")
    empty = window.picture((round(x) - 30, round(y) - 90, round(x) + 30, round(y) - 20))
    window.run("bpy.context.window_manager.shape_google.least_similarity = 0.0")
    assert np.asarray(empty, float).tobytes() != above.tobytes()


def test_nothing_moves_under_the_pointer(window: Any, indexed: Any, query: Any) -> None:
    """The buttons of a match are where they were before anything was found, also after a double click."""
    window.clean_scene(query, NAME)
    window.open("Search")
    window.run("bpy.context.window_manager.shape_google.matches.clear()")
    actions = ("find_similar", "append_match", "mark_match", "transfer_match", "mark_example")
    places = {action: window.find(action) for action in actions}

    def moved() -> list[str]:
        return [action for action, place in places.items() if action not in button_at(place)]

    def button_at(place: tuple[float, float]) -> str:
        window.move(*place)
        window.settle()  # a slow Blender answers for the place before
        return window.ask("button") or ""

    window.click(*places["find_similar"])
    state = window.wait(lambda state: state["matches"] and not state["session"]["searching"], "an answer")
    assert not moved()
    x, y = window.find("shape_google.choose_match", occurrence=1)
    for _ in range(2):
        window.tool("click", 1)
    window.wait(lambda state: state["session"]["active_match"] > 0, "another match chosen")
    window.settle()
    assert "choose_match" in button_at((x, y))
    window.open("Search")  # back to the top, from which the pictures may be out of sight
    assert not moved()
    window.click(*places["mark_example"])
    window.wait(
        lambda _: window.run("result = len(bpy.context.window_manager.shape_google.examples)"), "an example"
    )
    assert not moved()
    # A double click has chosen, and done nothing else.
    assert set(window.ask("state")["objects"]) == {NAME}
    assert state["matches"]
    window.run("bpy.context.window_manager.shape_google.examples.clear()")


def test_a_match_is_chosen_and_appended(window: Any, found: Any) -> None:
    window.press("shape_google.choose_match", occurrence=1)
    state = window.wait(lambda state: state["session"]["active_match"] > 0, "another match chosen")
    name = state["matches"][state["session"]["active_match"]]["object_name"]
    window.press("shape_google.append_match")
    state = window.wait(lambda state: name in state["objects"], f"{name} in the scene")
    assert state["active"] == name
    assert set(state["objects"]) == {NAME, name}
    window.undo()
    window.wait(lambda state: set(state["objects"]) == {NAME}, "undo takes it out again")


def test_the_gallery_chooses_appends_places_and_compares(window: Any, found: Any) -> None:
    sidebar = window.ask("regions")["ui"]
    window.press_beside("shape_google.find_similar", "shape_google.open_gallery")
    x, y = window.ask("pointer")
    button = x + 2, y - 8, x + 14, y + 8
    window.wait(lambda _: window.ask("gallery"), "the gallery")
    window.settle()
    # The sidebar is where it was, and in the gallery are pictures.
    assert window.ask("regions")["ui"][2:] == sidebar[2:]
    assert np.asarray(window.photograph(tuple(window.ask("gallery")["area"])), float).std() > 15
    x, y = window.ask("gallery")["pictures"][1]
    window.click(x, y)
    state = window.wait(lambda state: state["session"]["active_match"] == 1, "the second match chosen")
    name = state["matches"][1]["object_name"]
    window.settle()  # longer than a double click takes: three clicks would be two of them
    window.tool("click", "--repeat", 2, "--delay", 100, 1)
    window.wait(lambda state: set(state["objects"]) == {NAME, name}, f"{name} appended")
    window.undo()
    window.wait(lambda state: set(state["objects"]) == {NAME}, "undo takes it out again")
    left, top, right, bottom = window.ask("regions")["window"]
    target = left + 0.25 * (right - left), top + 0.8 * (bottom - top)
    window.drag(x, y, target[0] - x, target[1] - y)
    window.wait(lambda state: set(state["objects"]) == {NAME, name}, f"{name} placed")
    assert window.ask("stands_at", name) == pytest.approx(target, abs=3)
    window.move(x, y)
    window.settle()
    window.tool("key", "c")
    window.wait(lambda _: window.ask("gallery")["compared"], "both surfaces compared")
    area = tuple(window.ask("gallery")["area"])
    before = window.picture(area)
    assert colorful(before) > 0.02
    window.drag(x, y + 60, 80, 0)
    assert window.picture(area).tobytes() != before.tobytes()
    for open_after in (True, False):
        window.move(x, y)
        window.settle()
        window.tool("key", "Escape")
        window.wait(lambda _, wanted=open_after: bool(window.ask("gallery")) == wanted, "one step back")
        # The button is pressed as long as the gallery is open.
        assert (blue(window.picture(button)) > 0.3) == open_after
    assert window.ask("regions")["ui"] == sidebar


def test_find_similar_is_in_the_context_menu_of_the_object(window: Any, found: Any) -> None:
    window.run("bpy.context.window_manager.shape_google.matches.clear()")
    window.move(*window.ask("stands_at", NAME))
    window.tool("click", 3)
    window.settle()
    window.choose("shape_google.find_similar")
    state = window.wait(lambda state: state["matches"] and not state["session"]["searching"], "an answer")
    assert all(name.startswith("Horse") for name in horses(state))


# A grid of boxes by geometry nodes, and slices so short that there are many of them.
SCATTER = """
import importlib
tree = bpy.data.node_groups.new("Boxes", "GeometryNodeTree")
tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
names = ("NodeGroupOutput", "GeometryNodeMeshGrid", "GeometryNodeInstanceOnPoints", "GeometryNodeMeshCube")
output, grid, places, box = map(tree.nodes.new, names)
for axis in "XY":
    grid.inputs[f"Vertices {axis}"].default_value = 150
    grid.inputs[f"Size {axis}"].default_value = 300
tree.links.new(grid.outputs["Mesh"], places.inputs["Points"])
tree.links.new(box.outputs["Mesh"], places.inputs["Instance"])
tree.links.new(places.outputs["Instances"], output.inputs[0])
item = bpy.data.objects.new("Boxes", bpy.data.meshes.new("Boxes"))
bpy.context.scene.collection.objects.link(item)
item.modifiers.new("Boxes", "NODES").node_group = tree
for other in bpy.context.view_layer.objects:
    other.select_set(other == item)
bpy.context.view_layer.objects.active = item
query, slices = (importlib.import_module(f"{name}.{module}") for module in ("scene.query", "time_slices"))
query.SECONDS_OF_LISTING, slices.SECONDS_OF_SLICE = SECONDS
"""


def test_a_scatter_is_read_in_slices_which_escape_ends(window: Any, found: Any) -> None:
    usual = window.run(
        """import importlib
query, slices = (importlib.import_module(f"{name}.{module}") for module in ("scene.query", "time_slices"))
result = query.SECONDS_OF_LISTING, slices.SECONDS_OF_SLICE"""
    )
    window.run(SCATTER.replace("= SECONDS", "= 0.0, 0.0"))
    # For Blender a button stays disabled, as it was while the search ran, until the pointer moves.
    window.move(*window.ask("stands_at", NAME))
    window.press("shape_google.find_similar")
    window.wait(lambda state: state["session"]["answer"].startswith("Reading"), "the query being read")
    window.tool("key", "Escape")
    state = window.wait(lambda state: not state["session"]["searching"], "the end of reading")
    for kept in ("answer", "query"):
        assert state["session"][kept] == found["session"][kept]
    assert horses(state) == horses(found)
    window.move(*window.ask("stands_at", NAME))
    window.run(
        """import importlib
query, slices = (importlib.import_module(f"{name}.{module}") for module in ("scene.query", "time_slices"))
"""
        f"query.SECONDS_OF_LISTING, slices.SECONDS_OF_SLICE = {usual}"
    )
    window.press("shape_google.find_similar")
    state = window.wait(lambda state: state["session"]["query"] == "Boxes", "the whole query read")
    state = window.wait(lambda state: not state["session"]["searching"], "an answer")
    assert len(state["matches"]) == SHAPES


def test_moved_sources_are_found_in_their_new_place(window: Any, found: Any, shapes: Path) -> None:
    moved = shapes.rename(shapes.with_name("moved shapes"))

    def move(old: Path, new: Path) -> None:
        window.ask("begin_moving", str(old), str(new))
        window.settle()
        window.tool("key", "Return")
        window.wait(lambda state: f"moved to '{new}'" in state["session"]["summary"], "the sources moved")

    move(shapes, moved)
    window.open("Search")
    window.press("shape_google.choose_match", occurrence=1)
    state = window.wait(lambda state: state["session"]["active_match"] > 0, "another match chosen")
    name = state["matches"][state["session"]["active_match"]]["object_name"]
    window.press("shape_google.append_match")
    window.wait(lambda state: name in state["objects"], f"{name}, from the new place")
    moved.rename(shapes)
    move(moved, shapes)


def test_no_text_looks_like_a_bar_when_work_ends_under_the_pointer(
    window: Any, indexed: Any, folder: Any
) -> None:
    """The pointer rests where the work was started, which is where its bar is then."""
    window.open("Library")
    x, y = window.find("shape_google.index_library")
    library = window.run("result = preferences.library")
    # In a new library the number of shapes appears with the last redraw: there is one text more than before.
    window.run(f"preferences.library = {str(folder / 'another.sglib')!r}")
    window.click(x, y)
    window.wait(lambda state: state["session"]["indexing"], "indexing begun")
    window.wait(lambda state: not state["session"]["indexing"], "the end of indexing")
    window.settle()
    resting = window.photograph("ui")
    assert blue(resting) == pytest.approx(blue(window.picture("ui")), abs=0.005)
    window.run(f"preferences.library = {library!r}")
    window.wait(lambda state: state["session"]["shape_count"] == SHAPES, "the library again")
