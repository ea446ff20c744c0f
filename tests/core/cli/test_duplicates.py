# SPDX-License-Identifier: MIT
"""`shapegoogle duplicates`: a table, or one JSON object for each group."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

from shapegoogle_core.library.library import Library
from tests.core.cli.running import Shapegoogle


def test_copies_and_same_shapes_are_listed(
    shapegoogle: Shapegoogle, library: Library, folder: Path, make_mesh: Callable[..., Path], model_file: Path
) -> None:
    shutil.copy(folder / "apple.off", folder / "more" / "apple copy.off")
    make_mesh(folder / "apple.ply", seed=1)
    file = library.path
    library.close()
    assert shapegoogle("index", folder, "--library", file, "--jobs", "1").returncode == 0

    table = shapegoogle("duplicates", "--library", file, "--min-similarity", "1")
    assert table.returncode == 0, table.stderr
    assert "copies: 2 files" in table.stdout
    assert "identical: 2 shapes; " in table.stdout
    assert " faces besides the first" in table.stdout
    assert "2 groups among 5 shapes" in table.stdout

    lines = shapegoogle(
        "duplicates", "--library", file, "--min-similarity", "1", "--json"
    ).stdout.splitlines()
    groups = {record["kind"]: record for record in map(json.loads, lines)}
    assert [member["name"] for member in groups["copies"]["members"]] == ["apple.off", "apple copy.off"]
    assert groups["copies"]["saving"]["bytes"] == (folder / "apple.off").stat().st_size
    assert {member["name"] for member in groups["identical"]["members"]} == {"apple.off", "apple.ply"}


def test_wrong_usage_and_missing_libraries_end_with_2(
    shapegoogle: Shapegoogle, indexed: Library, tmp_path: Path
) -> None:
    wrong = shapegoogle("duplicates", "--library", indexed.path, "--min-similarity", "2")
    assert wrong.returncode == 2
    assert "at most 1" in wrong.stderr
    assert shapegoogle("duplicates", "--library", tmp_path / "none.sglib").returncode == 2
