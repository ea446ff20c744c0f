# SPDX-License-Identifier: MIT
"""Spellings of paths, on the file system and as texts of other systems."""

from __future__ import annotations

from pathlib import Path

import pytest

from shapegoogle_core.library.roots.keys import key_below
from shapegoogle_core.library.roots.paths import (
    absolute_path,
    joined,
    path_key,
    relative_to,
    spellings,
    top_folders,
)
from shapegoogle_core.library.storage.records import Root, SourceKey


@pytest.mark.parametrize(
    ("path", "folder", "relative"),
    [
        ("/assets/chairs/oak.obj", "/assets", "chairs/oak.obj"),
        ("/assets/oak.obj", "/", "assets/oak.obj"),
        ("/assets", "/assets", ""),
        ("/assets2/oak.obj", "/assets", None),
        ("/Assets/oak.obj", "/assets", None),
        ("/assets", "/assets/chairs", None),
        (r"C:\Assets\Chairs\Oak.obj", r"c:\assets", "Chairs/Oak.obj"),
        (r"C:\Assets\Oak.obj", "C:\\", "Assets/Oak.obj"),
        (r"D:\Assets\Oak.obj", r"C:\Assets", None),
        (r"\\nas\Models\Oak.obj", r"\\NAS\models", "Oak.obj"),
        (r"\\nas\models2\Oak.obj", r"\\nas\models", None),
        ("C:/Straße/oak.obj", r"c:\STRASSE", "oak.obj"),
        ("/mnt/c/oak.obj", r"C:\mnt", None),
    ],
)
def test_below(path: str, folder: str, relative: str | None) -> None:
    assert relative_to(path, folder) == relative


@pytest.mark.parametrize(
    ("path", "absolute"),
    [
        ("/assets//chairs/../oak.obj/", "/assets/oak.obj"),
        ("C:/assets/./chairs/../oak.obj", r"C:\assets\oak.obj"),
        (r"\\?\C:\assets\oak.obj", r"C:\assets\oak.obj"),
        (r"\\?\UNC\nas\models\oak.obj", r"\\nas\models\oak.obj"),
        ("\\\\nas\\models\\", r"\\nas\models"),
        ("C:\\", "C:\\"),
    ],
)
def test_absolute(path: str, absolute: str) -> None:
    assert absolute_path(path) == absolute


def test_joined_and_keys() -> None:
    assert joined("/assets", "chairs/oak.obj") == "/assets/chairs/oak.obj"
    assert joined("/", "oak.obj") == "/oak.obj"
    assert joined(r"\\nas\models", "chairs/oak.obj") == r"\\nas\models\chairs\oak.obj"
    assert joined("C:\\", "oak.obj") == r"C:\oak.obj"
    assert path_key(r"C:\Models", "Chairs/Oak.obj") == path_key(r"C:\Models", "chairs/OAK.obj")
    assert path_key("/models", "Oak.obj") != path_key("/models", "oak.obj")


def test_a_name_with_a_colon_is_no_drive() -> None:
    assert absolute_path("/assets/a:b.obj") == "/assets/a:b.obj"
    assert Path(absolute_path("a:b.obj")).is_absolute()


def test_the_longest_root_counts() -> None:
    roots = [Root("assets", "/assets"), Root("chairs", "/assets/chairs")]
    assert key_below("/assets/chairs/oak.obj", roots) == SourceKey("chairs", "oak.obj")
    assert key_below("/assets/chairs2/oak.obj", roots) == SourceKey("assets", "chairs2/oak.obj")
    assert key_below("/assets/../assets/chairs/oak.obj", roots[::-1]) == SourceKey("chairs", "oak.obj")
    assert key_below("/other/oak.obj", roots) is None
    assert key_below("/assets", roots) is None


def test_topmost_folders() -> None:
    assert top_folders(["/a/b", "/a/b/c", "/a/bc", "/d", "/a/b"]) == ["/a/b", "/a/bc", "/d"]


def test_links(tmp_path: Path) -> None:
    real, link = tmp_path / "real", tmp_path / "link"
    (real / ".store").mkdir(parents=True)
    link.symlink_to(real)
    (real / "oak.obj").touch()
    (real / ".store" / "9f86.obj").touch()
    (real / "same.obj").symlink_to(real / "oak.obj")
    (real / "stored.obj").symlink_to(real / ".store" / "9f86.obj")
    (real / "other.ply").symlink_to(real / "oak.obj")
    (tmp_path / "outside.obj").touch()
    (real / "outside.obj").symlink_to(tmp_path / "outside.obj")
    roots = [Root("real", str(real))]

    def found(path: Path) -> SourceKey | None:
        return key_below(str(path), roots)

    assert found(link / "oak.obj") == found(real / ".." / "link" / "oak.obj") == SourceKey("real", "oak.obj")
    assert found(link / "same.obj") == SourceKey("real", "oak.obj")
    # Contents named by their hashes are no names for people, and the suffix says how to read a file.
    assert found(link / "stored.obj") == SourceKey("real", "stored.obj")
    assert found(link / "other.ply") == SourceKey("real", "other.ply")
    assert found(link / "outside.obj") == SourceKey("real", "outside.obj")
    assert spellings(str(link / "oak.obj"))[0] == str(real / "oak.obj")
