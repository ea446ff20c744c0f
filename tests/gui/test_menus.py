# SPDX-License-Identifier: MIT
"""Find Similar in context menus of the Outliner and the Asset Browser; decisions in that of the gallery."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from tests.gui.conftest import CREATURES, NAME

# Turn the editor of properties, which is high enough, into another one, and say where it is.
TURN = """
window = bpy.context.window_manager.windows[0]
area = next(area for area in window.screen.areas if area.ui_type == {before!r})
area.ui_type = {after!r}
region = next(region for region in area.regions if region.type == "WINDOW")
result = [region.x, window.height - region.y - region.height, region.width, region.height]
"""
ASSETS = """
window = bpy.context.window_manager.windows[0]
space = next(area.spaces.active for area in window.screen.areas if area.ui_type == "ASSETS")
space.show_region_toolbar = space.show_region_tool_props = False
if space.params is not None:
    space.params.asset_library_reference = {library!r}
result = space.params is not None
"""
REGION = """
window = bpy.context.window_manager.windows[0]
area = next(area for area in window.screen.areas if area.ui_type == {editor!r})
region = next(region for region in area.regions if region.type == "WINDOW")
result = [region.x, window.height - region.y - region.height, region.width, region.height]
"""
# In pixels: the height of a row of the Outliner, and the middle of the first picture of an Asset Browser.
ROW, PICTURE = 20, (50, 50)


@contextmanager
def editor(window: Any, name: str) -> Iterator[None]:
    """Have another editor in place of that of properties."""
    window.run(TURN.format(before="PROPERTIES", after=name))
    window.settle()
    try:
        yield
    finally:
        window.run(TURN.format(before=name, after="PROPERTIES"))
        window.settle()


def forget_matches(window: Any) -> None:
    window.run("bpy.context.window_manager.shape_google.matches.clear()")


def wait_for_answer(window: Any) -> Any:
    return window.wait(lambda state: state["matches"] and not state["session"]["searching"], "an answer")


def test_find_similar_is_in_the_context_menu_of_the_outliner(window: Any, found: Any) -> None:
    forget_matches(window)
    window.run("for item in bpy.context.view_layer.objects: item.select_set(False)")
    left, top, width, height = window.run(REGION.format(editor="OUTLINER"))
    for row in range(height // ROW):
        window.click(left + width / 2, top + (row + 0.5) * ROW)
        window.settle()
        if window.ask("state")["objects"][NAME]["selected"]:
            break
    window.tool("click", 3)
    window.settle()
    window.choose("shape_google.find_similar")
    assert wait_for_answer(window)["session"]["query"] == NAME


def test_find_similar_is_in_the_context_menu_of_the_asset_browser(
    window: Any, found: Any, shapes: Any
) -> None:
    forget_matches(window)
    window.run(
        f"bpy.context.preferences.filepaths.asset_libraries.new(name='Shapes', directory={str(shapes)!r})"
    )
    try:
        with editor(window, "ASSETS"):
            window.wait(lambda _: window.run(ASSETS.format(library="Shapes")), "the Asset Browser")
            left, top, _, _ = window.run(REGION.format(editor="ASSETS"))
            # Assets are listed, and their pictures made, in the background.
            window.picture()
            window.click(left + PICTURE[0], top + PICTURE[1])
            window.settle()
            window.tool("click", 3)
            window.settle()
            window.choose("shape_google.find_similar_asset")
            state = wait_for_answer(window)
    finally:
        window.run(
            "libraries = bpy.context.preferences.filepaths.asset_libraries\n"
            "libraries.remove(libraries['Shapes'])"
        )
    names = {f"{kind} {pose}".title() for kind, poses in CREATURES.items() for pose in poses}
    assert state["session"]["query"] in names
    assert state["matches"][0]["object_name"] == state["session"]["query"]


def test_decisions_are_made_in_the_gallery_and_undone_in_their_panel(window: Any, found: Any) -> None:
    decisions = "result = [line.name for line in bpy.context.window_manager.shape_google.decisions]"
    assert window.run(decisions) == []
    window.press_beside("shape_google.find_similar", "shape_google.open_gallery")
    window.wait(lambda _: window.ask("gallery"), "the gallery")
    window.settle()
    x, y = window.ask("gallery")["pictures"][1]
    window.click(x, y)
    state = window.wait(lambda state: state["session"]["active_match"] == 1, "the second match chosen")
    for count, kind in enumerate(("MASTER", "KEEP_BOTH"), 1):
        window.move(x, y)
        window.settle()
        window.tool("click", 3)
        window.settle()
        window.choose(f"shape_google.decide_match(kind='{kind}')")
        window.wait(lambda _, count=count: len(window.run(decisions)) == count, f"the decision {kind}")
    assert all(state["matches"][1]["object_name"] in sentence for sentence in window.run(decisions))
    window.move(x, y)
    window.tool("key", "Escape")
    window.wait(lambda _: not window.ask("gallery"), "the gallery closed")
    window.open("Decisions")
    for _ in range(2):
        first, *rest = window.run(decisions)
        window.press("shape_google.undo_decisions")
        window.wait(lambda _, rest=rest: window.run(decisions) == rest, "the decision taken back")
        said = window.run("result = bpy.context.window_manager.shape_google.decided")
        assert said == f"Taken back: {first}"
