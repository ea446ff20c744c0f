# SPDX-License-Identifier: MIT
"""Workers that hang, and workers that still start, when their run is killed or interrupted."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from shapegoogle_core.library.library import Library
from tests.core.waiting import interruptible, wait_for_sources, wait_until_gone  # noqa: F401

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="signals and process groups as on Unix"),
    pytest.mark.usefixtures("interruptible"),
]

SCRIPT = """
import sys
from pathlib import Path

sys.path.insert(0, sys.argv[1])
from shapegoogle_core.indexing import IndexSettings, index_files
from shapegoogle_core.library.library import Library
from tests.core.indexing import misbehaving

if __name__ == "__main__":
    with Library.open(sys.argv[2]) as library:
        print("starts", flush=True)
        index_files(library, sys.argv[3:], IndexSettings(jobs=2, time_limit=3600), read=misbehaving.read)
"""


@pytest.fixture
def hanging_run(
    library: Library, tmp_path: Path, make_mesh: Callable[..., Path]
) -> Iterator[subprocess.Popen[str]]:
    """A run of which one worker does nothing any more and the other has stored its file."""
    (tmp_path / "run.py").write_text(SCRIPT)
    meshes = [make_mesh(tmp_path / name, seed) for seed, name in enumerate(("hangs.off", "apple.off"))]
    process = subprocess.Popen(
        [sys.executable, tmp_path / "run.py", Path(__file__).parents[3], library.path, *meshes],
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    yield process
    process.kill()
    process.communicate()


def test_a_hanging_worker_does_not_outlive_kill_9(
    library: Library, hanging_run: subprocess.Popen[str]
) -> None:
    wait_for_sources(library, 1, hanging_run)
    hanging_run.kill()
    hanging_run.wait()
    wait_until_gone(hanging_run.pid)


def test_control_c_ends_a_hanging_worker(library: Library, hanging_run: subprocess.Popen[str]) -> None:
    wait_for_sources(library, 1, hanging_run)
    os.killpg(hanging_run.pid, signal.SIGINT)
    hanging_run.communicate()
    wait_until_gone(hanging_run.pid)
    assert [shape.name for shape in library.shapes()] == ["apple.off"]


@pytest.mark.parametrize("delay", [0.0, 0.5])
def test_control_c_while_the_workers_start(
    library: Library, hanging_run: subprocess.Popen[str], delay: float
) -> None:
    """No worker prints a traceback of its own, whatever it was importing."""
    assert hanging_run.stdout is not None
    assert hanging_run.stdout.readline() == "starts\n"
    time.sleep(delay)
    os.killpg(hanging_run.pid, signal.SIGINT)
    _, stderr = hanging_run.communicate()
    wait_until_gone(hanging_run.pid)
    # The script does not catch it, so the main process prints its own.
    assert "KeyboardInterrupt" in stderr
    assert "spawn_main" not in stderr
