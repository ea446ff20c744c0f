# SPDX-License-Identifier: MIT
"""Training a model on the sources of the library."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library
from tests.addon.shapes import add_folder, lumpy


@pytest.mark.long
def test_train_a_model_on_this_library(folder: Path, preferences: Any, session: Any, tmp_path: Path) -> None:
    (folder / "broken.blend").unlink()
    for seed in range(3, 10):
        item = lumpy(f"Shape {seed}", seed, subdivisions=3)
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"shape{seed}.blend"), copy=True)
        bpy.data.objects.remove(item)
    add_folder(preferences, folder)
    model = tmp_path / "mine.npz"
    assert bpy.ops.shape_google.train_model(filepath=str(model)) == {"FINISHED"}
    assert session.trained == "Trained mine.npz; it is used for new libraries"
    assert (preferences.model, preferences.model_file) == ("FILE", str(model))
    bpy.ops.shape_google.index_library()
    with Library.open(preferences.library) as library:
        assert library.model.name == "mine"
