# SPDX-License-Identifier: MIT
"""Every file belongs to one shard, whatever the folder is called on a machine."""

from __future__ import annotations

import argparse
import unicodedata
from pathlib import Path

import pytest

from shapegoogle_core.cli.arguments import shard_from
from shapegoogle_core.indexing.shards import Shard, files_of_shard

NAMES = [f"set {number % 7}/mesh {number}.obj" for number in range(300)]


def shares(top: Path, count: int) -> list[list[str]]:
    paths = [top / name for name in NAMES]
    parts = [files_of_shard(paths, [top], Shard(number, count)) for number in range(1, count + 1)]
    return [[path.relative_to(top).as_posix() for path in part] for part in parts]


def test_each_file_is_in_one_shard() -> None:
    parts = shares(Path("/mnt/assets"), 3)
    assert sorted(name for part in parts for name in part) == sorted(NAMES)
    assert all(70 < len(part) < 130 for part in parts)


def test_all_machines_agree() -> None:
    assert shares(Path("/mnt/assets"), 3) == shares(Path("/Volumes/assets"), 3)


def test_letters_with_accents_are_the_same_however_a_system_writes_them() -> None:
    for name in ("chaise à bras.obj", "Möbel/Tür.obj", "がく.obj", "Ångström.obj"):
        composed, decomposed = (unicodedata.normalize(form, name) for form in ("NFC", "NFD"))
        assert composed != decomposed
        assert [Shard(number, 16).has(composed) for number in range(1, 17)] == [
            Shard(number, 16).has(decomposed) for number in range(1, 17)
        ]


def test_single_files_and_folders_in_each_other() -> None:
    paths = [Path("/a/b/c.obj"), Path("/elsewhere/d.obj")]
    for folders in ([Path("/a"), Path("/a/b")], [Path("/a/b"), Path("/a"), paths[1]]):
        parts = [files_of_shard(paths, folders, Shard(number, 2)) for number in (1, 2)]
        assert sorted(parts[0] + parts[1]) == paths
        assert (paths[0] in parts[0]) == Shard(1, 2).has("c.obj")


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "1/0", "a/b", "-1/2", "1/2/3"])
def test_shards_that_do_not_exist(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="must be I/N"):
        shard_from(text)
    assert shard_from("2/3") == Shard(2, 3)
