# SPDX-License-Identifier: MIT
"""What a person does with the add-on, in Blender's window: press buttons, look at what comes of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.creatures import make_creature
from tests.gui.conftest import CREATURES, FIRST, LAST, QUERY, colorful

NAME = "Rearing Horse"
SHAPES = sum(len(poses) for poses in CREATURES.values())


@pytest.fixture(scope="module")
def indexed(window: Any, query: Any) -> dict[str, Any]:
    """The library, indexed by a click; what was seen meanwhile."""
    window.clean_scene(query, NAME)
    window.open("Library")
    _, y = window.press("shape_google.index_library")
    left, _, right, _ = window.ask("regions")["ui"]
    button = left, round(y) - 8, right, round(y) + 8
    window.wait(lambda state: state["session"]["indexing"], "indexing begun")
    # Meanwhile the window is as usable as ever: turn the view.
    direction = window.ask("view_direction")
    left, top, right, bottom = window.ask("regions")["window"]

    def is_turned() -> Any:
        return window.ask("view_direction") != direction

    for _ in range(4):  # a slow Blender may miss one
        window.drag(left + 0.3 * (right - left), (top + bottom) / 2, 60, 0, button=2)
        window.settle()
        if is_turned():
            break
    window.wait(lambda _: is_turned(), "the view turned")
    turned = window.ask("state")["session"]["indexing"]
    window.rest()
    window.settle()
    window.ask("count_draws")
    seen: dict[int, str] = {}
    bar = None

    def ended(state: Any) -> Any:
        nonlocal bar
        session = state["session"]
        if session["indexing"] and session["done"]:
            seen[session["done"]] = session["progress"]
            bar = bar or window.photograph(button)
        return not session["indexing"]

    state = window.wait(ended, "the end of indexing")
    draws = window.ask("count_draws")
    return {"state": state, "draws": draws, "seen": seen, "turned": turned, "bar": bar} | {
        "button": window.picture(button)
    }


@pytest.fixture
def found(window: Any, indexed: Any, query: Any) -> dict[str, Any]:
    """The answer to a click on Find Similar, in a scene with nothing but the query."""
    window.clean_scene(query, NAME)
    window.open("Search")
    window.run(
        "session = bpy.context.window_manager.shape_google\nsession.collapse = False\nsession.matches.clear()"
    )
    window.press("shape_google.find_similar")
    window.wait(
        lambda state: state["matches"] and not state["session"]["searching"], "an answer to the query"
    )
    state: dict[str, Any] = window.wait(
        lambda state: all("Comparing" not in match["kind"] for match in state["matches"]), "kinds of matches"
    )
    return state


def blue(image: Any) -> Any:
    """Share of the pixels of a picture in the blue of progress bars and of what is chosen."""
    pixels = np.asarray(image, np.int16)
    return float((pixels[..., 2] - pixels[..., 0] > 60).mean())


def horses(state: Any) -> Any:
    return [match["object_name"] for match in state["matches"][: len(CREATURES["horse"])]]


def test_index_library_goes_on_beside_a_usable_window(indexed: Any) -> None:
    state = indexed["state"]
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
    assert window.ask("regions")["ui"] == sidebar


def test_find_similar_is_in_the_context_menu_of_the_object(window: Any, found: Any) -> None:
    window.run("bpy.context.window_manager.shape_google.matches.clear()")
    window.move(*window.ask("stands_at", NAME))
    window.tool("click", 3)
    window.settle()
    window.choose("shape_google.find_similar")
    state = window.wait(lambda state: state["matches"] and not state["session"]["searching"], "an answer")
    assert all(name.startswith("Horse") for name in horses(state))


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


def test_mark_shows_both_shapes_in_the_same_colours(window: Any, found: Any) -> None:
    before = window.picture("window")
    window.press("shape_google.mark_match")
    state = window.wait(
        lambda state: (
            len(state["objects"]) == 2
            and all("sg_word" in item["attributes"] for item in state["objects"].values())
        ),
        "both shapes painted",
    )
    other = next(name for name in state["objects"] if name != NAME)
    colors: dict[int, set[Any]] = {}
    words = []
    for name in (NAME, other):
        item_words, item_colors = window.ask("word_colors", name)
        words.append(set(item_words))
        for word, color in zip(item_words, item_colors, strict=True):
            colors.setdefault(word, set()).add(tuple(color))
    assert len(words[0] & words[1]) > 5
    assert all(len(values) == 1 for values in colors.values())
    window.ask("look")
    assert colorful(window.picture("window")) > colorful(before) + 0.005


def begin_transfer(window: Any) -> None:
    """From the best match, a horse in another pose, by a click; then its worker waits to be released."""
    window.press("shape_google.transfer_match")
    window.wait(
        lambda state: state["transferring"] and window.ask("hold_worker"), "the transfer begun, and held"
    )


@pytest.fixture
def transferring(window: Any, found: Any) -> Iterator[None]:
    """A transfer that waits; whatever comes of the test, nothing waits behind it."""
    begin_transfer(window)
    yield
    window.ask("release_worker")
    window.wait(lambda state: not state["transferring"], "the end of the transfer")


def test_transfer_carries_weights_and_is_undone_and_redone(window: Any, transferring: Any) -> None:
    def there(state: Any) -> Any:
        item = state["objects"][NAME]
        return (item["groups"], item["colors"]) == (["High"], ["Coat"])

    window.ask("release_worker")
    state = window.wait(there, "the match's vertex group and colours on the query")
    assert set(state["objects"]) == {NAME}
    height = make_creature(QUERY[0], 2011, vertex_count=QUERY[2]).pose("rest").vertices[:, 2]
    expected = (height - height.min()) / np.ptp(height)
    assert np.abs(np.array(window.ask("weights", NAME, "High")) - expected).mean() < 0.05
    window.run(
        "bpy.context.view_layer.objects.active = bpy.data.objects[0]\n"
        "bpy.ops.object.mode_set(mode='WEIGHT_PAINT')"
    )
    assert colorful(window.picture("window")) > 0.03
    window.run("bpy.ops.object.mode_set(mode='OBJECT')")
    window.undo()
    window.wait(lambda state: not there(state), "undo takes them off")
    window.redo()
    window.wait(there, "redo brings them back")


def test_a_transfer_is_cancelled_by_escape_and_in_the_panel(window: Any, transferring: Any) -> None:
    left, top, right, bottom = window.ask("regions")["window"]
    window.move(left + 0.3 * (right - left), (top + bottom) / 2)
    window.tool("key", "Escape")
    window.wait(lambda state: not state["transferring"], "the transfer cancelled")
    begin_transfer(window)
    window.press_beside("shape_google.transfer_match", "shape_google.cancel_transfer")
    state = window.wait(lambda state: not state["transferring"], "that one cancelled")
    assert not state["objects"][NAME]["groups"]


def test_a_transfer_is_for_the_object_that_it_began_with(window: Any, transferring: Any, query: Any) -> None:
    window.ask("add_object", str(query), "Other", [2, 0, 0])
    window.ask("release_worker")
    state = window.wait(lambda state: not state["transferring"], "the end of the transfer")
    assert state["objects"][NAME]["groups"] == ["High"]
    assert not state["objects"]["Other"]["groups"]


def test_a_transfer_survives_that_its_object_is_deleted(window: Any, transferring: Any) -> None:
    left, top, right, bottom = window.ask("regions")["window"]
    window.move(left + 0.3 * (right - left), (top + bottom) / 2)
    window.tool("key", "Delete")
    window.wait(lambda state: not state["objects"], "the object deleted")
    window.ask("release_worker")
    state = window.wait(lambda state: not state["transferring"], "the end of the transfer")
    assert not state["objects"]


def test_opening_a_file_ends_a_transfer(window: Any, transferring: Any, folder: Path) -> None:
    window.run(f"bpy.ops.wm.save_as_mainfile(filepath={str(folder / 'query.blend')!r})")
    window.press("shape_google.open_match")
    state = window.wait(lambda state: "Horse Rest" in state["objects"], "the file of the match")
    assert not state["transferring"]
    # The file brings its own windows, with the sidebar closed.
    window.ask("show_sidebar")
    window.wait(lambda state: window.ask("show_tab"), "the tab of the add-on")
    window.run("bpy.context.view_layer.objects.active = bpy.data.objects['Horse Rest']")
    assert window.run("result = bpy.ops.shape_google.find_similar.poll()")


def test_paint_signature_slide_and_undo(window: Any, query: Any) -> None:
    window.clean_scene(query, NAME)
    window.run("bpy.context.scene.shape_google_painting.kind = 'HKS'")
    window.open("Signature")
    before = window.picture("window")
    window.press("bpy.ops.shape_google.paint")
    window.wait(lambda state: "sg_hks" in state["objects"][NAME]["attributes"], "the signature painted")
    colors = window.ask("colors", NAME)
    assert len({tuple(color) for color in colors}) > 100
    painted = window.picture("window")
    assert colorful(painted) > colorful(before) + 0.005

    x, y = window.find("shape_google_painting.scale")
    left, _, right, _ = window.ask("regions")["ui"]
    window.drag(x, y, (right - left) / 5, 0)
    state = window.wait(lambda state: not math.isclose(state["painting"]["scale"], 0.5), "the slider moved")
    assert state["painting"]["scale"] > 0.5
    assert window.ask("colors", NAME) != colors
    assert window.picture("window").tobytes() != painted.tobytes()

    window.undo()
    window.settle()
    window.undo()
    window.wait(lambda state: not state["objects"][NAME]["attributes"], "undo takes the signature off")
    assert colorful(window.picture("window")) == pytest.approx(colorful(before), abs=0.01)


def test_keypoints_are_painted_selected_and_undone(window: Any, query: Any) -> None:
    window.clean_scene(query, NAME)
    window.run("bpy.context.scene.shape_google_painting.kind = 'KEYPOINTS'")
    window.open("Signature")
    before = window.picture("window")
    window.press("bpy.ops.shape_google.paint")
    window.wait(lambda state: "sg_keypoint" in state["objects"][NAME]["attributes"], "keypoints painted")
    # Some tips are on the far side: a few spots, and all else nearly grey.
    assert colorful(before) + 0.0003 < colorful(window.picture("window")) < colorful(before) + 0.02
    window.press("shape_google.select_keypoints")
    selected = window.run(
        "import bmesh, bpy\n"
        f"mesh = bmesh.from_edit_mesh(bpy.data.objects[{NAME!r}].data)\n"
        "result = sum(vertex.select for vertex in mesh.verts)"
    )
    assert 3 < selected < 20
    assert window.run("result = bpy.context.mode") == "EDIT_MESH"
    window.undo()
    window.settle()
    assert window.run("result = bpy.context.mode") == "OBJECT"
    assert "sg_keypoint" in window.ask("state")["objects"][NAME]["attributes"]


def test_duplicates_are_found_linked_and_unlinked(window: Any, query: Any) -> None:
    window.clean_scene(query, "First")
    window.ask("add_object", str(query), "Second", [2, 0, 0])
    window.open("Duplicates")
    window.press("shape_google.find_duplicates")
    state = window.wait(
        lambda state: state["duplicates"]["groups"] and not state["duplicates"]["running"], "a group"
    )
    (group,) = state["duplicates"]["groups"]
    assert group == {"kind": "IDENTICAL", "chosen": False, "members": ["First", "Second"]}
    window.press(".chosen", columns=FIRST)
    window.wait(lambda state: state["duplicates"]["groups"][0]["chosen"], "the group chosen")
    window.press("shape_google.link_duplicates")

    def shared(state: Any) -> Any:
        return state["objects"]["First"]["data"] == state["objects"]["Second"]["data"]

    window.wait(shared, "both objects with one mesh")
    window.undo()
    window.wait(lambda state: not shared(state), "undo gives each its own mesh again")
