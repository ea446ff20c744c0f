# SPDX-License-Identifier: MIT
"""Runs that are killed or interrupted: nothing stored is lost, the next run does the rest."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from shapegoogle_core.library.library import Library
from tests.core.cli.running import Shapegoogle, StartShapegoogle, without_progress
from tests.core.waiting import interruptible, wait_for_sources, wait_until_gone  # noqa: F401

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="signals and process groups as on Unix"),
    pytest.mark.usefixtures("interruptible"),
]

FILES = 16


@pytest.fixture
def many(tmp_path: Path, make_mesh: Callable[..., Path]) -> Path:
    for seed in range(FILES):
        make_mesh(tmp_path / "meshes" / f"{seed:02}.off", seed=seed, subdivisions=4)
    return tmp_path / "meshes"


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder for temporary files of the commands."""
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setenv("TMPDIR", str(place))
    return place


def test_kill_9_then_control_c_then_the_rest(
    library: Library,
    many: Path,
    library_file: Path,
    start_shapegoogle: StartShapegoogle,
    shapegoogle: Shapegoogle,
    temporary: Path,
    tmp_path: Path,
) -> None:
    arguments = ("index", many, "--library", library_file)
    process = start_shapegoogle(*arguments, "--jobs", "2")
    wait_for_sources(library, 3, process)
    process.kill()
    process.wait()
    # The workers notice that nobody waits for them any more.
    wait_until_gone(process.pid)
    (left,) = temporary.iterdir()
    # Any command removes what is left; one that runs keeps its own.
    shapegoogle("info", "--library", library_file)
    assert not left.exists()
    killed = {shape.source: shape.shape_id for shape in library.shapes()}

    log = tmp_path / "run.log"
    process = start_shapegoogle(*arguments, "--log", log, "--jobs", "2")
    wait_for_sources(library, len(killed) + 1, process)
    while " added " not in log.read_text(encoding="utf-8"):  # at once, as for `tail -f`
        assert process.poll() is None, "the command ended too early"
        time.sleep(0.05)
    # As a terminal does: to the command and its workers.
    os.killpg(process.pid, signal.SIGINT)
    stdout, printed = process.communicate()
    stderr = without_progress(printed)
    assert (process.returncode, stdout) == (130, "")
    assert stderr.startswith("shapegoogle: interrupted after ")
    assert stderr.endswith(
        f"of {FILES} files; everything stored so far is kept, run the same command again to continue\n"
    )
    assert stderr.count("\n") == 1
    assert " WARNING interrupted: " in log.read_text(encoding="utf-8").splitlines()[-1]
    wait_until_gone(process.pid)
    assert list(temporary.iterdir()) == []

    # The library is sound, and the next run does what is missing, no more.
    before = {shape.source: shape.shape_id for shape in library.shapes()}
    assert killed.items() < before.items()
    assert len(before) < FILES
    assert len(library.query(library.signature(min(before.values())), top=FILES, explain=0)) == len(before)
    done = shapegoogle(*arguments, "--jobs", "1")
    assert (done.returncode, done.stderr) == (0, "")
    new = FILES - len(before)
    assert done.stdout.startswith(f"{new} shapes added from {new} files, {len(before)} files unchanged")
    after = {shape.source: shape.shape_id for shape in library.shapes()}
    assert sorted(after) == sorted(map(str, many.iterdir()))
    assert before.items() <= after.items()
    assert list(temporary.iterdir()) == []


def test_sigterm_leaves_nothing_behind(
    library: Library,
    many: Path,
    library_file: Path,
    start_shapegoogle: StartShapegoogle,
    temporary: Path,
) -> None:
    """As the window ends a run in the background: to the command alone."""
    process = start_shapegoogle("index", many, "--library", library_file, "--jobs", "2")
    wait_for_sources(library, 3, process)
    assert list(temporary.iterdir())
    process.terminate()
    stdout, printed = process.communicate()
    stderr = without_progress(printed)
    assert (process.returncode, stdout) == (130, "")
    assert stderr.startswith("shapegoogle: interrupted after ")
    wait_until_gone(process.pid)
    assert list(temporary.iterdir()) == []
