# SPDX-License-Identifier: MIT
"""`shapegoogle duplicates`: a table, or one JSON object for each group."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

from shapegoogle_core.library.library import Library
from tests.core.cli.running import Command


def test_copies_and_same_shapes_are_listed(
    run: Command, library: Library, folder: Path, make_mesh: Callable[..., Path]
) -> None:
    shutil.copy(folder / "apple.off", folder / "more" / "apple copy.off")
    make_mesh(folder / "apple.ply", seed=1)
    file = library.path
    library.close()
    assert run("index", folder, "--library", file, "--jobs", "1")[0] == 0

    code, table, stderr = run("duplicates", "--library", file, "--min-similarity", "1")
    assert code == 0, stderr
    assert "copies: 2 files" in table
    assert "identical: 2 shapes; " in table
    assert " faces besides the first" in table
    assert "2 groups among 5 shapes" in table

    _, lines, _ = run("duplicates", "--library", file, "--min-similarity", "1", "--json")
    groups = {record["kind"]: record for record in map(json.loads, lines.splitlines())}
    assert [member["name"] for member in groups["copies"]["members"]] == ["apple.off", "apple copy.off"]
    assert groups["copies"]["saving"]["bytes"] == (folder / "apple.off").stat().st_size
    assert {member["name"] for member in groups["identical"]["members"]} == {"apple.off", "apple.ply"}


def test_wrong_usage_and_missing_libraries_end_with_2(run: Command, indexed: Library, tmp_path: Path) -> None:
    code, _, stderr = run("duplicates", "--library", indexed.path, "--min-similarity", "2")
    assert code == 2
    assert "at most 1" in stderr
    assert run("duplicates", "--library", tmp_path / "none.sglib")[0] == 2
