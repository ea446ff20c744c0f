# SPDX-License-Identifier: MIT
"""Transferring from a match in Blender's window, and everything that may come between."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.creatures import make_creature
from tests.gui.conftest import NAME, QUERY
from tests.gui.window import colorful


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
