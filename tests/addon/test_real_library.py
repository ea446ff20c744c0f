# SPDX-License-Identifier: MIT
"""A real folder of .blend files, indexed and searched by the scripts, where it is at hand."""

from __future__ import annotations

import os
from pathlib import Path

import bpy
import pytest

from benchmarks.experiments import blend_library

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(os.environ.get("SHAPEGOOGLE_DATA", ROOT.parent / "shared" / "data")) / "blend_library"

pytestmark = [
    pytest.mark.real_data,
    pytest.mark.skipif(not FOLDER.is_dir(), reason=f"no {FOLDER}; set SHAPEGOOGLE_DATA"),
    pytest.mark.skipif(bool(bpy.app.binary_path), reason="the scripts need the extension in a real Blender"),
]


def test_index_and_find_the_same_person(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    library = tmp_path / "shapes.sglib"
    blend_library.index(FOLDER, library, jobs=1)
    blend_library.poses(FOLDER, "posed_characters", library)
    printed = capsys.readouterr().out
    assert "index: exit code 0" in printed
    assert " shapes added from 164 files" in printed
    assert "nothing to do: 164 files unchanged" in printed
    right, total = (int(word) for word in printed.split("poses: exit code 0, ")[1].split()[:3:2])
    assert total == 180
    assert right >= 0.95 * total
