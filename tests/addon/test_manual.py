# SPDX-License-Identifier: MIT
"""The script in the manual runs as it is printed."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy


def test_the_manual_can_be_opened(addon: ModuleType) -> None:
    page = importlib.import_module(f"{addon.__name__}.documentation").manual()
    assert "Find Similar" in page.read_text(encoding="utf-8")
    assert bpy.ops.shape_google.open_manual.poll()


def test_the_manual_s_script(folder: Path, preferences: Any, session: Any, tmp_path: Path) -> None:
    manual = (Path(__file__).parents[2] / "docs" / "blender" / "index.md").read_text(encoding="utf-8")
    script = manual.partition("```python\n")[2].partition("```")[0]
    assert "find_similar" in script
    script = script.replace("/library/studio.sglib", str(tmp_path / "studio.sglib"))
    script = script.replace("/library/assets", str(folder))
    # In tests the add-on is a folder of the repository, and nothing is there twice.
    script = script.replace('endswith("shape_google")', 'endswith(("shape_google", "blender_addon"))')
    script = script.replace("bpy.ops.shape_google.link_duplicates()", "")
    exec(compile(script, "manual", "exec"), {})
    assert len(session.matches) == 2  # different shapes, without the one that is no match
    assert "sg_word" in bpy.context.active_object.data.attributes
