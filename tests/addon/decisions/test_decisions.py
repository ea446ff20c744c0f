# SPDX-License-Identifier: MIT
"""Decisions about matches and duplicates, in the library, and taking them back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library
from tests.addon.shapes import lumpy


@pytest.fixture
def found(indexed: Path, session: Any, preferences: Any) -> Any:
    """Matches of a pear that is in no file."""
    session.collapse = False
    preferences.author = "ana"
    lumpy("Query", 1)
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    return session


def choose(session: Any, name: str) -> None:
    names = [match.name for match in session.matches]
    assert bpy.ops.shape_google.choose_match(index=names.index(name)) == {"FINISHED"}


def names(session: Any) -> list[str]:
    return [match.name for match in session.matches]


def test_what_is_no_match_is_not_found_until_that_is_undone(
    found: Any, preferences: Any, blender: Any
) -> None:
    choose(found, "Plum")
    assert bpy.ops.shape_google.decide_match(kind="NOT_A_MATCH") == {"FINISHED"}
    assert found.decided == "Plum is no match for Query"
    assert "Plum" not in names(found)
    # The query may be moved and scaled, and the decision is known to everyone who uses the library.
    query = bpy.data.objects["Query"]
    query.location, query.scale = (3, 1, 2), (2, 2, 2)
    bpy.context.view_layer.update()
    bpy.ops.shape_google.find_similar()
    assert "Plum" not in names(found)
    with Library.open(preferences.library_path(), read_only=True) as library:
        (decision,) = library.decisions()
    assert (decision.kind, decision.author, decision.shape.title) == ("not a match", "ana", "Query")

    found.decisions.clear()
    assert bpy.ops.shape_google.list_decisions() == {"FINISHED"}
    (line,) = found.decisions
    assert (line.name, line.author) == ("Plum is no match for Query", "ana")
    assert bpy.ops.shape_google.undo_decisions() == {"FINISHED"}
    assert not len(found.decisions)
    assert "Plum" in names(found)
    assert not bpy.ops.shape_google.undo_decisions.poll()


def test_a_card_stands_for_its_versions(found: Any, session: Any) -> None:
    session.collapse = True
    lumpy("Stone", 2)  # the plum, of which nut.obj is a copy
    bpy.ops.shape_google.find_similar()
    assert session.matches[0].version_count == 1
    bpy.ops.shape_google.choose_match(index=0)
    bpy.ops.shape_google.decide_match(kind="NOT_A_MATCH")
    assert not {"Plum", "nut.obj"} & set(names(session))
    assert len(session.decisions) == 2
    for line in session.decisions:
        line.chosen = True
    bpy.ops.shape_google.undo_decisions()
    assert session.decided == "2 decisions taken back"
    assert session.matches[0].version_count == 1


def test_duplicates_follow_what_is_decided(found: Any, session: Any) -> None:
    shown = bpy.context.window_manager.shape_google_duplicates
    shown.groups.clear()
    assert not bpy.ops.shape_google.decide_duplicate.poll()
    shown.scope = "LIBRARY"
    bpy.ops.shape_google.find_duplicates()
    (group,) = shown.groups
    assert {member.name for member in group.members} == {"Plum", "nut.obj"}
    group.active_member = 1
    second = group.members[1].name
    assert bpy.ops.shape_google.decide_duplicate(kind="MASTER") == {"FINISHED"}
    assert shown.groups[0].members[0].name == second
    shown.groups[0].active_member = 1
    assert bpy.ops.shape_google.decide_duplicate(kind="KEEP_BOTH") == {"FINISHED"}
    assert not len(shown.groups)
    bpy.ops.shape_google.find_duplicates()
    assert not len(shown.groups)
    assert [line.icon for line in session.decisions] == ["DUPLICATE", "FUND"]
    shown.scope = "SCENE"


def test_without_a_name_decisions_have_that_of_the_account(
    found: Any, preferences: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    preferences.author = "  "
    assert preferences.author_name()
    choose(found, "Apple")
    bpy.ops.shape_google.decide_match(kind="MASTER")
    assert found.decisions[0].author == preferences.author_name()
    assert found.decided == "Apple is the master among its duplicates"
