# SPDX-License-Identifier: MIT
"""The process that computes for a window: results, errors, cancelling, dying, and scripts that start it."""

from __future__ import annotations

import io
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.errors import MeshError, ShapeGoogleError
from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.processes.launching import launch
from shapegoogle_core.processes.messages import read_frame, write_frame
from shapegoogle_core.processes.worker import Worker
from tests.core.processes import pool_tasks


@pytest.fixture
def worker() -> Iterator[Worker]:
    worker = Worker()
    yield worker
    worker.stop()


def test_results_and_errors(worker: Worker, tmp_path: Path) -> None:
    assert not worker.started
    tasks = [worker.submit(abs, -number) for number in range(5)]
    assert [task.result() for task in tasks] == list(range(5))
    array = np.arange(1e6)
    np.testing.assert_array_equal(worker.submit(np.sqrt, array).result(), np.sqrt(array))
    with pytest.raises(MeshError, match="does not exist"):
        worker.submit(read_mesh, tmp_path / "gone.obj").result()
    with pytest.raises(ShapeGoogleError, match="because of a fault in Shape Google; report it"):
        worker.submit(abs, "three").result()
    with pytest.raises(Exception, match="pickle"):
        worker.submit(lambda: 3).result()
    # What is printed does not end up among the answers.
    worker.submit(print, "noise").result()
    assert worker.submit(abs, -3).result() == 3


# As in Blender, whose Python does not ignore SIGPIPE. The worker is stopped, so that the task is still being
# written to it when it is killed.
CANCEL_WHILE_WRITING = """
import os, signal, time
from shapegoogle_core.processes.worker import Worker

signal.signal(signal.SIGPIPE, signal.SIG_DFL)
worker = Worker()
os.kill(worker.submit(os.getpid).result(), signal.SIGSTOP)
task = worker.submit(len, bytes(10**7))
while not task.running():
    time.sleep(0.01)
time.sleep(0.5)
assert task.cancel()
assert worker.submit(abs, -3).result() == 3
worker.stop()
print("alive")
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_cancelling_while_a_task_is_written_does_not_end_this_process() -> None:
    command = [sys.executable, "-c", CANCEL_WHILE_WRITING]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert (done.returncode, done.stdout) == (0, "alive\n"), done.stderr


def test_cancelling(worker: Worker) -> None:
    running = worker.submit(time.sleep, 3600)
    waiting = worker.submit(abs, -1)
    while not running.running():
        time.sleep(0.01)
    assert waiting.cancel()
    assert running.cancel()
    with pytest.raises(CancelledError):
        running.result()
    done = worker.submit(abs, -2)
    assert done.result() == 2
    assert not done.cancel()


def test_a_process_that_dies(worker: Worker) -> None:
    with pytest.raises(ShapeGoogleError, match=r"ended unexpectedly \(exit code 7\)"):
        worker.submit(os._exit, 7).result()
    assert worker.submit(abs, -2).result() == 2


def test_stopping_gives_up_all_tasks(worker: Worker) -> None:
    tasks = [worker.submit(time.sleep, 3600), worker.submit(time.sleep, 3600)]
    while not tasks[0].running():
        time.sleep(0.01)
    worker.stop()
    assert all(task.done() for task in tasks)
    assert worker.submit(abs, -2).result() == 2


def test_it_does_not_run_the_script_again(tmp_path: Path) -> None:
    """No guard, and an import that only the first process can do, as scripts in Blender are written."""
    script = tmp_path / "user.py"
    script.write_text(
        "import os, sys\n"
        "print('run')\n"
        "from shapegoogle_core.processes.worker import Worker\n"
        "worker = Worker()\n"
        "print(worker.submit(abs, -3).result())\n"
        "worker.stop()\n"
    )
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["run", "3"]


def test_a_late_cancel_does_not_hit_the_next_task(worker: Worker, tmp_path: Path) -> None:
    first = worker.submit(abs, -1)
    first.result()
    second = worker.submit(pool_tasks.wait_for, tmp_path / "go")
    while not second.running():
        time.sleep(0.01)
    # As when the first one finished after `cancel` had asked whether it was done.
    assert not worker.abandon(first)
    (tmp_path / "go").touch()
    assert second.result() is None


@pytest.mark.skipif(sys.platform == "win32", reason="closes a file as only Unix can")
def test_without_standard_error() -> None:
    tasks = io.BytesIO()
    for task in ((print, ("noise",)), (abs, (-3,))):
        write_frame(tasks, pickle.dumps(task))
    code = "import os; os.close(2); from shapegoogle_core.processes.worker import serve; serve()"
    process, pipe = launch([sys.executable, "-c", code])
    process.communicate(tasks.getvalue())
    with pipe:
        answers = [read_frame(pipe) for _ in range(3)]
    assert process.returncode == 0
    assert [answer and pickle.loads(answer) for answer in answers] == [(True, None), (True, 3), None]


def test_messages_of_any_size_survive_what_libraries_print(worker: Worker) -> None:
    """From C, before and after a task, and without an end of the line."""
    huge = "\u2028ä" * 5_000_000
    for _ in range(2):
        worker.submit(os.write, 1, b"a library talks").result()
        assert worker.submit(str.upper, huge).result() == huge.upper()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
def test_a_process_that_dies_in_the_middle_of_an_answer(worker: Worker) -> None:
    with pytest.raises(ShapeGoogleError, match=r"ended unexpectedly \(SIGKILL"):
        worker.submit(pool_tasks.die_while_answering).result()
    assert worker.submit(abs, -2).result() == 2
