# SPDX-License-Identifier: MIT
"""The session outlasts the opening of a file, and the preferences that of Blender."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import pytest

from tests.addon.shapes import lumpy


def test_the_file_of_a_match_is_opened_with_its_results(
    indexed: Path, preferences: Any, session: Any, tmp_path: Path
) -> None:
    lumpy("Query", 1)
    bpy.ops.shape_google.find_similar()
    session.errors.add().name = "broken.blend"
    session.least_similarity = 0.25
    bpy.ops.shape_google.mark_example(unlike=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"), copy=True)
    for load_ui in (True, False):
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "other.blend"), load_ui=load_ui)
        kept = bpy.context.window_manager.shape_google
        assert not kept.matches  # of the objects of another file
        assert "broken.blend" in [error.name for error in kept.errors]
        assert kept.least_similarity == pytest.approx(0.25)
        assert [(example.name, example.unlike) for example in kept.examples] == [("Pear", True)]
    lumpy("Again", 1)
    bpy.ops.shape_google.clear_examples()
    bpy.ops.shape_google.find_similar()
    # The file of the best match is open now: it can be selected there.
    bpy.ops.shape_google.open_match()
    kept = bpy.context.window_manager.shape_google
    assert [match.name for match in kept.matches if match.in_scene] == ["Pear"]
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    bpy.ops.wm.read_homefile(use_empty=True)


def test_what_is_chosen_is_saved(preferences: Any, tmp_path: Path) -> None:
    for change in (
        lambda: bpy.ops.shape_google.choose_library(filepath=str(tmp_path / "new")),
        lambda: bpy.ops.shape_google.add_folder(directory=str(tmp_path)),
        lambda: setattr(preferences.folders[0], "use", False),
        lambda: bpy.ops.shape_google.remove_folder(),
    ):
        bpy.context.preferences.is_dirty = False
        change()
        assert bpy.context.preferences.is_dirty
    assert preferences.library == str(tmp_path / "new.sglib")
    # A path beside the open file would mean another one in the next file.
    preferences.library = "//lib.sglib"
    assert Path(preferences.library).is_absolute()
