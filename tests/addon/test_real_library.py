# SPDX-License-Identifier: MIT
"""A real folder of .blend files, indexed and searched by the scripts, where it is at hand."""

from __future__ import annotations

import os
import shutil
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


PERSONS = "posed_characters"


# Every day all persons among every fifth of the other files, then all of them.
@pytest.mark.parametrize("step", [5, pytest.param(1, marks=pytest.mark.long)])
def test_index_and_find_the_same_person(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], step: int
) -> None:
    folder, library = tmp_path / "files", tmp_path / "shapes.sglib"
    others = sorted(path for path in FOLDER.rglob("*.blend") if path.parent.name != PERSONS)[::step]
    files = [*(FOLDER / PERSONS).glob("*.blend"), *others]
    for path in files:
        copy = folder / path.relative_to(FOLDER)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, copy)
    blend_library.index(folder, library, jobs=1)
    blend_library.poses(folder, PERSONS, library)
    printed = capsys.readouterr().out
    assert "index: exit code 0" in printed
    assert f" shapes added from {len(files)} files" in printed
    assert f"nothing to do: {len(files)} files unchanged" in printed
    right, total = (int(word) for word in printed.split("poses: exit code 0, ")[1].split()[:3:2])
    assert total == 180
    assert right >= 0.95 * total
