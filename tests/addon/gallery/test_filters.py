# SPDX-License-Identifier: MIT
"""Filters and versions act in the search itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library
from tests.addon.shapes import lumpy


def names(session: Any) -> list[str]:
    bpy.ops.shape_google.find_similar()
    return [match.name for match in session.matches]


@pytest.fixture
def query(indexed: Path) -> Any:
    """A copy of Plum, which is there as nut.obj too."""
    return lumpy("Query", 2)


def test_filters(query: Any, indexed: Path, session: Any) -> None:
    # Plum and its copy are versions of each other; Apple and Pear are as plain, but other shapes.
    assert len(names(session)) == 3
    assert session.answer.startswith("Query: 3 different shapes, the best of 4, ")
    session.collapse = False
    assert len(names(session)) == 4
    assert session.answer.startswith("Query: 4 shapes, the best of 4, ")
    # In the name or in the path, whatever the case.
    session.text = "NUT"
    assert names(session) == ["nut.obj"]
    assert session.answer.startswith("Query: 1 shape that meets the filters, the best of 4, ")
    session.text = f"{indexed.name}/pe"
    assert names(session) == ["Pear"]
    session.text = ""
    session.least_similarity = 1.0
    assert set(names(session)) == {"Plum", "nut.obj"}
    session.least_similarity = 0
    session.use_size, session.size_tolerance = True, 0.1
    assert set(names(session)) == {"Plum", "nut.obj"}
    query.scale = 2, 2, 2
    assert names(session) == []
    assert session.answer == "Query: no match meets the filters among 4 shapes"
    session.use_size = False
    session.source = "SCENE"
    assert names(session) == []
    session.source = "FILES"
    assert len(names(session)) == 4


def test_with_few_results_the_filter_still_finds_what_is_far_down(query: Any, session: Any) -> None:
    session.top, session.text = 1, "pear"
    assert names(session) == ["Pear"]


def test_so_many_different_shapes_are_found_however_many_versions_there_are(
    query: Any, preferences: Any, session: Any
) -> None:
    """Copies must not take the places of other shapes."""
    with Library.open(preferences.library) as library:
        plum = next(shape for shape in library.shapes() if shape.name == "Plum")
        signature = library.signature(plum.shape_id)
        for number in range(30):
            library.add_signature(signature, f"Plum {number}")
    session.top = 2
    assert names(session)[1] in ("Apple", "Pear")
    assert [match.version_count for match in session.matches] == [31, 0]
    session.collapse = False
    assert all(name.startswith(("Plum", "nut")) for name in names(session))


def test_versions_are_shown_and_used(query: Any, session: Any) -> None:
    assert names(session)[0] in ("Plum", "nut.obj")
    assert bpy.ops.shape_google.show_versions() == {"FINISHED"}
    assert (session.opened, {match.name for match in session.versions}) == (0, {"Plum", "nut.obj"})
    assert {match.kind for match in session.versions} <= {"Identical", "Moved"}
    # What is done with a match is done with the version that is chosen.
    index = [match.name for match in session.versions].index("nut.obj")
    bpy.ops.shape_google.choose_match(index=index)
    assert not bpy.ops.shape_google.link_match.poll()
    assert bpy.ops.shape_google.append_match() == {"FINISHED"}
    assert len(bpy.context.active_object.data.vertices) == 642
    bpy.ops.shape_google.show_versions()
    assert (session.opened, len(session.versions), session.active_match) == (-1, 0, 0)
    # A shape without any has nothing to open.
    session.text = "apple"
    assert names(session) == ["Apple"]
    bpy.ops.shape_google.show_versions()
    assert session.opened == -1
