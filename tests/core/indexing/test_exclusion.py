# SPDX-License-Identifier: MIT
"""Patterns of files to leave out; git is asked what its own would match."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing import find_meshes
from shapegoogle_core.indexing.exclusion import Exclusion

PATHS = [
    "a.obj",
    "ab.obj",
    "b.stl",
    "old/a.obj",
    "old/new/a.obj",
    "new/old/a.obj",
    "new/old/deep/er/b.stl",
    "new/old.obj",
    "x/y/z/a.obj",
    "x/a.obj",
    "name [1].obj",
    "two\nlines.obj",
    "a-b.obj",
    "a]b.obj",
    "*.obj",
]
PATTERNS = [
    "a.obj",
    "/a.obj",
    "*.obj",
    "?.obj",
    "a?.obj",
    "old",
    "old/",
    "/old",
    "/old/",
    "new/old",
    "new/old/",
    "**/old",
    "**/old/a.obj",
    "old/**",
    "old/**/",
    "new/**/b.stl",
    "x/**/a.obj",
    "x/*/a.obj",
    "x/**",
    "**/a.obj",
    "**",
    "*",
    "[ab].*",
    "[!a].*",
    "[^a].*",
    "[a-b].stl",
    "[]b].obj",
    "a[]-]b.obj",
    "name \\[1\\].obj",
    "\\*.obj",
    "two*",
    "[",
    "a[b.obj",
    "deep",
    "er/b.stl",
    "new/old/deep/er/b.stl",
]


@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
def test_they_mean_what_they_mean_to_git(tmp_path: Path) -> None:
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    for path in PATHS:
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).touch()
    for pattern in PATTERNS:
        (tmp_path / ".gitignore").write_text(pattern + "\n")
        command = ["git", "-C", str(tmp_path), "-c", "core.ignoreCase=false", "check-ignore", "--no-index"]
        done = subprocess.run(
            [*command, "-z", "--stdin"],
            input="\0".join(PATHS),
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode in (0, 1), done.stderr
        expected = set(done.stdout.split("\0")) - {""}
        assert {path for path in PATHS if Exclusion([pattern]).excludes(path)} == expected, pattern


@pytest.mark.parametrize("pattern", ["", "/", "//", "!a.obj"])
def test_patterns_that_mean_nothing(pattern: str) -> None:
    with pytest.raises(ValueError, match=re.escape(repr(pattern))):
        Exclusion([pattern])


def test_finding_meshes(tmp_path: Path) -> None:
    for path in ("keep.obj", "draft_1.obj", "notes.txt", "old/gone.obj", "new/old/x.obj", "new/keep.stl"):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).touch()
    excluded: list[Path] = []
    found = find_meshes(tmp_path, exclude=["draft_*", "old/", "*.txt"], on_excluded=excluded.append)
    assert [path.relative_to(tmp_path).as_posix() for path in found] == ["keep.obj", "new/keep.stl"]
    # A folder stands for all that is in it; it is not searched.
    names = sorted(path.relative_to(tmp_path).as_posix() for path in excluded)
    assert names == ["draft_1.obj", "new/old", "old"]
    # A file that is named itself is left out by its name.
    assert find_meshes([tmp_path / "draft_1.obj", tmp_path / "keep.obj"], exclude="draft_*") == [
        tmp_path / "keep.obj"
    ]
    # Nothing is missing where everything was left out on purpose.
    assert find_meshes(tmp_path, exclude="*") == []
    with pytest.raises(MeshError, match="has no mesh files"):
        find_meshes(tmp_path, suffixes={".ply"}, exclude="*.stl")
