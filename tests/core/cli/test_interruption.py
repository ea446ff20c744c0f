# SPDX-License-Identifier: MIT
"""Runs that are killed or interrupted: nothing stored is lost, the next run does the rest."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from shapegoogle_core.library import Library

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and process groups as on Unix")

FILES = 16


@pytest.fixture
def many(tmp_path: Path, make_mesh) -> Path:
    for seed in range(FILES):
        make_mesh(tmp_path / "meshes" / f"{seed:02}.off", seed=seed, subdivisions=4)
    return tmp_path / "meshes"


def wait_for_sources(library: Library, wanted: int, process: subprocess.Popen[str]) -> None:
    """Wait until the running command has stored so many files."""
    while len(library.sources()) < wanted:
        assert process.poll() is None, "the command ended too early"
        time.sleep(0.05)


def wait_until_gone(group: int) -> None:
    """Wait until no process is left in a group; a worker that never ends lets this test hang, not pass."""
    while True:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)


def check_the_rest(library: Library, many: Path, library_file: Path, shapegoogle) -> None:
    """The library is sound and the next run does what is missing, no more."""
    before = {shape.source: shape.shape_id for shape in library.shapes()}
    assert 3 <= len(before) < FILES
    assert len(library.query_signature(library.signature(min(before.values())), top=FILES)) == len(before)
    done = shapegoogle("index", many, "--library", library_file, "--jobs", "1")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"{FILES - len(before)} added, 0 updated, {len(before)} unchanged")
    after = {shape.source: shape.shape_id for shape in library.shapes()}
    assert sorted(after) == sorted(map(str, many.iterdir()))
    assert before.items() <= after.items()


def test_kill_9(library: Library, many: Path, library_file: Path, start_shapegoogle, shapegoogle) -> None:
    process = start_shapegoogle("index", many, "--library", library_file, "--jobs", "2")
    wait_for_sources(library, 3, process)
    process.kill()
    process.wait()
    # The workers notice that nobody waits for them any more.
    wait_until_gone(process.pid)
    check_the_rest(library, many, library_file, shapegoogle)


def test_control_c(library: Library, many: Path, library_file: Path, start_shapegoogle, shapegoogle) -> None:
    process = start_shapegoogle("index", many, "--library", library_file, "--jobs", "2")
    wait_for_sources(library, 3, process)
    # As a terminal does: to the command and its workers.
    os.killpg(process.pid, signal.SIGINT)
    stdout, stderr = process.communicate()
    assert (process.returncode, stdout) == (130, "")
    assert stderr.startswith("shapegoogle: interrupted after ")
    assert stderr.endswith(
        f"of {FILES} files; everything stored so far is kept, run the same command again to continue\n"
    )
    assert stderr.count("\n") == 1
    wait_until_gone(process.pid)
    check_the_rest(library, many, library_file, shapegoogle)


SCRIPT = """
import sys
from pathlib import Path

sys.path.insert(0, sys.argv[1])
import misbehaving
from shapegoogle_core.indexing import index_files
from shapegoogle_core.library import Library

if __name__ == "__main__":
    with Library.open(sys.argv[2]) as library:
        print("starts", flush=True)
        index_files(library, sys.argv[3:], jobs=2, time_limit=3600, read=misbehaving.read)
"""


@pytest.fixture
def hanging_run(library: Library, tmp_path: Path, make_mesh):
    """A run of which one worker does nothing any more and the other has stored its file."""
    (tmp_path / "run.py").write_text(SCRIPT)
    meshes = [make_mesh(tmp_path / name, seed) for seed, name in enumerate(("hangs.off", "apple.off"))]
    process = subprocess.Popen(
        [sys.executable, tmp_path / "run.py", Path(__file__).parent, library.path, *meshes],
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    yield process
    process.kill()
    process.communicate()


def test_a_hanging_worker_does_not_outlive_kill_9(library: Library, hanging_run) -> None:
    wait_for_sources(library, 1, hanging_run)
    hanging_run.kill()
    hanging_run.wait()
    wait_until_gone(hanging_run.pid)


def test_control_c_ends_a_hanging_worker(library: Library, hanging_run) -> None:
    wait_for_sources(library, 1, hanging_run)
    os.killpg(hanging_run.pid, signal.SIGINT)
    hanging_run.communicate()
    wait_until_gone(hanging_run.pid)
    assert [shape.name for shape in library.shapes()] == ["apple.off"]


@pytest.mark.parametrize("delay", [0.0, 0.5])
def test_control_c_while_the_workers_start(library: Library, hanging_run, delay: float) -> None:
    """No worker prints a traceback of its own, whatever it was importing."""
    assert hanging_run.stdout.readline() == "starts\n"
    time.sleep(delay)
    os.killpg(hanging_run.pid, signal.SIGINT)
    _, stderr = hanging_run.communicate()
    wait_until_gone(hanging_run.pid)
    # The script does not catch it, so the main process prints its own.
    assert "KeyboardInterrupt" in stderr
    assert "spawn_main" not in stderr


def test_sigterm_leaves_nothing_behind(
    library: Library, many: Path, library_file: Path, tmp_path: Path, start_shapegoogle, monkeypatch
) -> None:
    """As the window ends a run in the background: to the command alone."""
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setenv("TMPDIR", str(place))
    process = start_shapegoogle("index", many, "--library", library_file, "--jobs", "2")
    wait_for_sources(library, 3, process)
    assert list(place.iterdir())
    process.terminate()
    stdout, stderr = process.communicate()
    assert (process.returncode, stdout) == (130, "")
    assert stderr.startswith("shapegoogle: interrupted after ")
    wait_until_gone(process.pid)
    assert list(place.iterdir()) == []
