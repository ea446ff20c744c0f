# SPDX-License-Identifier: MIT
"""Folders for temporary files: those of killed processes are removed, no others."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from shapegoogle_core.processes.temporary import remove_abandoned_folders, temporary_folder

OWNER = """
import sys, tempfile
from shapegoogle_core.processes.temporary import temporary_folder

tempfile.tempdir = sys.argv[1]
with temporary_folder() as folder:
    (folder / "below").mkdir()
    (folder / "below" / "arrays").write_bytes(b"x")
    print(folder, flush=True)
    sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


@pytest.fixture
def owner(place: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that has a folder for temporary files until its input is closed."""
    command = [sys.executable, "-c", OWNER, str(place)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    yield process
    process.kill()
    process.communicate()


def folder_of(owner: subprocess.Popen[str]) -> Path:
    assert owner.stdout is not None
    folder = Path(owner.stdout.readline().strip())
    assert (folder / "below" / "arrays").exists()
    return folder


def test_the_folder_of_a_killed_process_is_removed(owner: subprocess.Popen[str]) -> None:
    folder = folder_of(owner)
    assert remove_abandoned_folders() == []
    assert folder.exists()
    owner.kill()
    owner.wait()
    assert folder.exists()
    assert remove_abandoned_folders() == [folder]
    assert not folder.exists()


def test_whoever_needs_a_folder_removes_the_others(owner: subprocess.Popen[str], place: Path) -> None:
    abandoned = folder_of(owner)
    owner.kill()
    owner.wait()
    with temporary_folder() as folder:
        assert not abandoned.exists()
        # One process may have several; none is taken for abandoned, by itself either.
        with temporary_folder() as other:
            assert remove_abandoned_folders() == []
            assert set(place.iterdir()) == {folder, other}
    assert not list(place.iterdir())


def test_an_orderly_end_leaves_nothing(owner: subprocess.Popen[str], place: Path) -> None:
    folder_of(owner)
    owner.communicate()
    assert not list(place.iterdir())


def test_what_only_looks_alike_stays(owner: subprocess.Popen[str], place: Path) -> None:
    folder = folder_of(owner)
    owner.kill()
    owner.wait()
    title = (folder / "owner").read_text()
    assert platform.node() in title
    (folder / "owner").write_text("somebody's notes")
    for name in (
        "shapegoogle-backup",
        "shapegoogle-12345678x",
        "my-shapegoogle-12345678",
        "shapegoogle-ABCDEFGH",
    ):
        (place / name).mkdir()
        (place / name / "owner").write_text(title)
    (place / "shapegoogle-no_owner").mkdir()
    (place / "shapegoogle-elsewher").mkdir()
    (place / "shapegoogle-elsewher" / "owner").write_text(title.replace(platform.node(), "another-machine"))
    (place / "shapegoogle-thatfile").write_text(title)
    (place / "shapegoogle-nothing_").mkdir()
    (place / "shapegoogle-nothing_" / "owner").touch()
    before = sorted(place.rglob("*"))
    assert remove_abandoned_folders() == []
    assert sorted(place.rglob("*")) == before
    # Its own folder is recognised again by the right title.
    (folder / "owner").write_text(title)
    assert remove_abandoned_folders() == [folder]


@pytest.mark.skipif(sys.platform == "win32", reason="links and users as on Unix")
def test_links_and_folders_of_other_users_stay(owner: subprocess.Popen[str], place: Path) -> None:
    folder = folder_of(owner)
    owner.kill()
    owner.wait()
    away = folder.rename(place / "away")
    (place / "shapegoogle-a_link__").symlink_to(away)
    (place / "shapegoogle-owner_is").mkdir()
    (place / "shapegoogle-owner_is" / "owner").symlink_to(away / "owner")
    if os.geteuid() == 0:
        other = place / "shapegoogle-stranger"
        other.mkdir()
        (other / "owner").write_bytes((away / "owner").read_bytes())
        os.chown(other, 12345, 12345)
    assert remove_abandoned_folders() == []
    assert (away / "below" / "arrays").exists()
