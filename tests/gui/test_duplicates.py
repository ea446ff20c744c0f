# SPDX-License-Identifier: MIT
"""Duplicates of the scene in Blender's window."""

from __future__ import annotations

from typing import Any

from tests.gui.window import FIRST


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
