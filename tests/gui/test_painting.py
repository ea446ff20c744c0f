# SPDX-License-Identifier: MIT
"""Colours in Blender's window: words of two shapes, signatures, keypoints."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.gui.conftest import NAME
from tests.gui.window import colorful


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
