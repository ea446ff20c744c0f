# SPDX-License-Identifier: MIT
"""Appending, linking, importing and marking matches."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from tests.addon.shapes import lumpy


def test_append_and_mark(indexed: Path, preferences: Any, session: Any) -> None:
    query = lumpy("Query", 1)
    bpy.ops.shape_google.find_similar()
    bpy.context.scene.cursor.location = 10, 0, 0
    bpy.ops.shape_google.append_match()
    pear = bpy.data.objects["Pear"]
    assert pear.library is None
    assert (pear.matrix_world.translation - bpy.context.scene.cursor.location).length < 3
    assert bpy.context.active_object == pear

    bpy.context.view_layer.objects.active = query
    assert bpy.ops.shape_google.mark_match() == {"FINISHED"}
    beside = bpy.data.objects["Pear.001"]
    assert {item.name for item in bpy.context.selected_objects} == {"Query", "Pear.001"}
    # The same mesh has the same words, vertex by vertex.
    words = [
        np.array([entry.value for entry in item.data.attributes["sg_word"].data]) for item in (query, beside)
    ]
    assert (words[0] == words[1]).mean() > 0.99
    assert len(np.unique(words[0])) > 1
    colors = [item.data.color_attributes["sg_color"] for item in (query, beside)]
    np.testing.assert_allclose(colors[0].data[0].color[:], colors[1].data[0].color[:])
    low = min((beside.matrix_world @ vertex.co).x for vertex in beside.data.vertices)
    high = max((query.matrix_world @ vertex.co).x for vertex in query.data.vertices)
    assert low > high


def test_import_a_mesh_file_and_refuse_what_is_gone(indexed: Path, preferences: Any, session: Any) -> None:
    lumpy("Query", 2)
    session.collapse = False
    bpy.ops.shape_google.find_similar()
    index = [match.name for match in session.matches].index("nut.obj")
    bpy.ops.shape_google.choose_match(index=index)
    assert not bpy.ops.shape_google.link_match.poll()
    assert not bpy.ops.shape_google.open_match.poll()
    bpy.ops.shape_google.append_match()
    assert len(bpy.context.active_object.data.vertices) == 642
    (indexed / "nut.obj").unlink()
    with pytest.raises(RuntimeError, match=r"nut\.obj' does not exist any more"):
        bpy.ops.shape_google.append_match()


def test_link(indexed: Path, preferences: Any, session: Any) -> None:
    lumpy("Query", 0)
    bpy.ops.shape_google.find_similar()
    bpy.ops.shape_google.link_match()
    assert bpy.data.objects["Apple"].library is not None
    bpy.data.libraries.remove(bpy.data.libraries[0])
