# SPDX-License-Identifier: MIT
"""Files that hang, crash, eat memory or change: each costs itself, nothing else."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.indexing import (
    FileOutcome,
    IndexReport,
    IndexSettings,
    ShapeReader,
    find_meshes,
    index_files,
)
from shapegoogle_core.indexing.progress.tracking import ProgressTracker
from shapegoogle_core.indexing.reading.file_pool import FilePool
from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel
from tests.core.indexing import misbehaving

SOUND = ["apple.off", "pear.obj", "prints.off", "quince.off"]
linux_only = pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux only")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, make_mesh: Callable[..., Path]) -> Path:
    folder = tmp_path_factory.mktemp("models")
    bad = ["aborts", "exits", "raises", "changes", "vanishes", "prints"]
    bad += ["swells"] if sys.platform == "linux" else []
    for seed, stem in enumerate((*bad, "apple", "quince")):
        make_mesh(folder / f"{stem}.off", seed=seed)
    make_mesh(folder / "pear.obj", seed=20)
    # Waits for the one that aborts, as its content is the same, and shares its fate.
    shutil.copy(folder / "aborts.off", folder / "copy_of_aborts.off")
    return folder


@pytest.fixture(scope="module")
def outcomes() -> list[FileOutcome]:
    return []


@pytest.fixture(scope="module")
def library(folder: Path, model: ShapeModel, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Library]:
    with Library.open(tmp_path_factory.mktemp("library") / "shapes.sglib", model) as library:
        yield library


@pytest.fixture(scope="module")
def report(library: Library, folder: Path, outcomes: list[FileOutcome]) -> IndexReport:
    """One run over all of them with two processes."""
    return index_files(
        library,
        find_meshes([folder]),
        IndexSettings(jobs=2, time_limit=3600, memory_limit=1024),
        progress=outcomes.append,
        read=misbehaving.read,
    )


@pytest.fixture(scope="module")
def reasons(report: IndexReport) -> dict[str, str]:
    return {path.name: reason for path, reason in report.failed}


def test_all_others_are_stored(report: IndexReport, library: Library) -> None:
    assert (report.added, report.updated, report.unchanged) == (len(SOUND), 0, 0)
    assert sorted(shape.name for shape in library.shapes()) == SOUND


def test_every_file_is_accounted_for(report: IndexReport, outcomes: list[FileOutcome]) -> None:
    failed = {outcome.path: outcome.reason for outcome in outcomes if outcome.status == "failed"}
    assert failed == dict(report.failed)
    assert len(outcomes) == len({outcome.path for outcome in outcomes}) == report.added + len(report.failed)


@pytest.fixture(scope="module")
def hanging(library: Library, folder: Path, make_mesh: Callable[..., Path]) -> tuple[Path, IndexReport]:
    """A file that hangs, and a run over it alone: a slow machine may exceed its limit with other files."""
    path = make_mesh(folder.with_name("hanging") / "hangs.off", seed=30)
    settings = IndexSettings(jobs=1, time_limit=0.5)
    return path, index_files(library, [path], settings, read=misbehaving.read)


def test_hanging(hanging: tuple[Path, IndexReport]) -> None:
    path, report = hanging
    ((failed, reason),) = report.failed
    assert failed == path
    assert reason.startswith("'hangs.off' was not done after 0.5 s")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
def test_crashing(reasons: dict[str, str]) -> None:
    assert "'aborts.off' crashed the process that read it (SIGABRT)" in reasons["aborts.off"]


def test_ending_the_process(reasons: dict[str, str]) -> None:
    assert "'exits.off' crashed the process that read it (exit code 3)" in reasons["exits.off"]


@linux_only
def test_eating_memory(reasons: dict[str, str]) -> None:
    assert reasons["swells.off"].startswith("'swells.off' needs more than 1024 MB of memory")


def test_an_error_nobody_foresaw(reasons: dict[str, str], outcomes: list[FileOutcome]) -> None:
    assert reasons["raises.off"] == (
        "'raises.off' cannot be described because of a fault in Shape Google, not in the file; report it "
        "with what --verbose shows"
    )
    outcome = next(outcome for outcome in outcomes if outcome.path.name == "raises.off")
    assert "Traceback" in outcome.details
    assert "misbehaving.py" in outcome.details


def test_a_copy_of_a_failed_file(reasons: dict[str, str], folder: Path) -> None:
    assert reasons["copy_of_aborts.off"].startswith(
        f"'copy_of_aborts.off' has the same content as '{folder / 'aborts.off'}', which failed: 'aborts.off'"
    )


def test_changing_while_it_is_read(reasons: dict[str, str], library: Library, folder: Path) -> None:
    assert "'changes.off' changed or vanished while it was read" in reasons["changes.off"]
    # Not remembered: the next run has another look.
    assert str(folder / "changes.off") not in library.sources()


def test_vanishing_while_it_is_read(reasons: dict[str, str], library: Library, folder: Path) -> None:
    assert "'vanishes.off' changed or vanished while it was read" in reasons["vanishes.off"]
    assert str(folder / "vanishes.off") not in library.sources()


@pytest.mark.usefixtures("report")
def test_failures_are_remembered_until_asked_to_retry(
    library: Library, folder: Path, hanging: tuple[Path, IndexReport]
) -> None:
    again = [folder / "raises.off", hanging[0]]
    # If the second one were read again, this would take an hour.
    settings = IndexSettings(jobs=1, time_limit=3600)
    report = index_files(library, again, settings, read=misbehaving.read)
    reasons = [reason for _, reason in report.failed]
    assert reasons[0].startswith("'raises.off' cannot be described")
    assert reasons[1].startswith("'hangs.off' was not done after 0.5 s")
    assert all(reason.endswith("(found in an earlier run; --retry tries it again)") for reason in reasons)

    # The describing function of everyday use has nothing against the name.
    report = index_files(library, again, IndexSettings(jobs=1, retry=True))
    assert (report.added, report.failed) == (2, [])


@pytest.mark.usefixtures("report")
def test_a_failed_file_is_tried_again_when_it_changes(
    library: Library, folder: Path, make_mesh: Callable[..., Path]
) -> None:
    make_mesh(folder / "exits.off", seed=77)
    report = index_files(library, [folder / "exits.off"], IndexSettings(jobs=1))
    assert (report.added, report.updated, report.failed) == (1, 0, [])


def test_files_that_cannot_be_opened(library: Library, tmp_path: Path) -> None:
    folder = tmp_path / "folder.obj"
    folder.mkdir()
    paths = [tmp_path / "gone.obj", folder]
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.gltf")
        paths.append(tmp_path / "pipe.gltf")
    report = index_files(library, paths)
    assert [path for path, _ in report.failed] == paths
    assert report.failed[0][1].startswith("'gone.obj' cannot be read: No such file")
    assert all("'folder.obj'" in reason or "ordinary" in reason for _, reason in report.failed[1:])
    # Trouble with the disk is no property of the file.
    assert not any(str(path) in library.sources() for path in paths)


def test_a_script_that_only_one_process_can_import(tmp_path: Path, folder: Path) -> None:
    script = tmp_path / "index.py"
    script.write_text(
        "import sys\n"
        "if __name__ != '__main__':\n"
        "    raise ImportError('nothing for a worker')\n"
        "from shapegoogle_core.cli import main\n"
        "sys.exit(main(sys.argv[1:]))\n"
    )
    library = str(tmp_path / "shapes.sglib")
    command = [sys.executable, str(script), "index", str(folder), "--library", library]
    # It must end at all: a process that died early once kept its starter waiting for ever.
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert "the worker processes end before they do anything" in run.stderr


def test_processes_that_cannot_start() -> None:
    class BrokenModel:
        def to_bytes(self) -> bytes:
            return b"no model"

    pool = FilePool(
        BrokenModel(),  # type: ignore[arg-type]
        None,
        ShapeReader.iterate,
        1,
        IndexSettings(time_limit=3600, memory_limit=1024),
        ProgressTracker(None),
    )
    with pool:
        pool.submit(Path("apple.off"))
        with pytest.raises(ShapeGoogleError, match="the worker processes end before they do anything"):
            pool.finished()
