# SPDX-License-Identifier: MIT
"""Filters of the matches."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy

from tests.addon.shapes import lumpy


def test_filters(addon: ModuleType, indexed: Path, preferences: Any, session: Any) -> None:
    shown_matches = importlib.import_module(f"{addon.__name__}.gallery.filters").shown_matches
    lumpy("Query", 2)
    bpy.ops.shape_google.find_similar()
    # Plum and the .obj made of it are the same mesh.
    assert len(session.matches) == 4
    assert len(shown_matches(session)) == 3
    session.collapse = False
    assert len(shown_matches(session)) == 4
    session.text = "NUT"
    assert [match.name for _, match in shown_matches(session)] == ["nut.obj"]
    session.text = ""
    session.least_similarity = 1.0
    assert {match.name for _, match in shown_matches(session)} == {"Plum", "nut.obj"}
    session.least_similarity = 0
    session.use_size, session.size_tolerance = True, 0.1
    assert {match.name for _, match in shown_matches(session)} == {"Plum", "nut.obj"}
    session.source = "SCENE"
    assert shown_matches(session) == []
