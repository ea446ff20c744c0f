# SPDX-License-Identifier: MIT
"""The pool: order, limits, tasks that end their processes, and processes that cannot start."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.processes import pool as pool_module
from shapegoogle_core.processes.pool import CrashError, Pool, PoolTask, TimeLimitError
from tests.core.processes import pool_tasks

# No task of these tests comes near it.
LONG = 3600.0


def test_results_come_in_the_order_of_the_items() -> None:
    with Pool(2, LONG) as pool:
        assert [task.result() for task in pool.map(abs, [-3, 2, -1, 0, -7, 5, -9, 4])] == [
            3, 2, 1, 0, 7, 5, 9, 4,
        ]  # fmt: skip
        assert len(pool) == 0
        assert pool.finished() == []


def test_a_task_that_fails_costs_only_itself(capfd: pytest.CaptureFixture[str]) -> None:
    words = ["one", "abort", "two", "exit", "raise", "print", "three"]
    with Pool(2, LONG) as pool:
        tasks = {task.arguments[0]: task for task in pool.map(pool_tasks.misbehave, words)}
    for word in ("one", "two", "three", "print"):
        assert tasks[word].result() == word
    with pytest.raises(CrashError, match=r"^exit code 3$"):
        tasks["exit"].result()
    with pytest.raises(LookupError, match="an unexpected error"):
        tasks["raise"].result()
    with pytest.raises(CrashError, match="exit code" if sys.platform == "win32" else "^SIGABRT$"):
        tasks["abort"].result()
    # Output of libraries does not get among that of the command.
    printed = capfd.readouterr()
    assert "output of a library" not in printed.out
    assert "output of a library" in printed.err


def test_a_task_may_have_no_limit() -> None:
    with Pool(1, 0.5) as pool:
        task = pool.submit(pool_tasks.misbehave, "wait", limited=False)
        while not task.done:
            pool.finished()
        assert task.result() == "wait"


def test_a_task_whose_process_died_before_that_was_known_is_run_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Pebble may read that a process died before it reads that the process had begun a task."""
    monkeypatch.setattr(pool_module, "LOST_AFTER", 0.2)
    with Pool(1, LONG) as pool:
        task: PoolTask[Any] = pool.submit(pool_tasks.misbehave, "hang")
        manager = pool._pool._pool_manager
        while not any(known.worker_id for known in list(manager.task_manager.tasks.values())):
            time.sleep(0.05)
        (process,) = manager.worker_manager.workers.values()
        # What is left of the task then: begun by a process that nobody watches.
        monkeypatch.setattr(manager, "find_expired_task", raise_lookup_error)
        process.kill()
        task.function, task.arguments = abs, (-3,)
        assert pool.finished() == [task]
        assert task.result() == 3


def raise_lookup_error(_worker_id: int) -> None:
    raise LookupError


def test_a_task_that_takes_too_long_is_killed() -> None:
    # The limit is that of the hanging task alone: the other is done before it begins.
    with Pool(1, LONG) as pool:
        assert [task.result() for task in pool.map(pool_tasks.misbehave, ["one"])] == ["one"]
    with Pool(1, 1.0) as pool:
        (task,) = pool.map(pool_tasks.misbehave, ["hang"])
        with pytest.raises(TimeLimitError):
            task.result()


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux only")
def test_a_task_that_needs_too_much_memory() -> None:
    with Pool(1, LONG, memory_limit=1024) as pool:
        swelling, other = pool.map(pool_tasks.misbehave, ["swell", "one"])
        with pytest.raises(MemoryError):
            swelling.result()
        assert other.result() == "one"


def test_each_process_is_prepared_once(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with Pool(2, LONG, start=pool_tasks.prepare, start_arguments=(log,)) as pool:
        results = [task.result() for task in pool.map(pool_tasks.add_to_start, range(20))]
    assert results == [(True, number) for number in range(20)]
    processes = log.read_text().splitlines()
    assert len(processes) == len(set(processes)) <= 2
    assert str(os.getpid()) not in processes


def test_tasks_that_go_first(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with Pool(1, LONG) as pool:
        for word in "abcdef":
            pool.submit(pool_tasks.log_and_return, log, word)
        pool.submit(pool_tasks.log_and_return, log, "first", first=True)
        while len(pool):
            pool.finished()
    words = log.read_text().split()
    assert sorted(words) == sorted([*"abcdef", "first"])
    # Three were in the hands of the process already, and one may have been handed out since.
    assert words.index("first") <= 4


def test_temporary_files_go_where_they_are_removed(tmp_path: Path) -> None:
    with Pool(1, LONG, folder=tmp_path) as pool:
        task = pool.submit(pool_tasks.where_temporary_files_go)
        pool.finished()
    assert Path(task.result()) == tmp_path


def test_leaving_the_block_ends_what_runs() -> None:
    with Pool(1, LONG) as pool:
        task = pool.submit(time.sleep, 3600)
    # An hour later it would be.
    assert not task.done


def test_processes_that_cannot_start() -> None:
    with Pool(1, LONG, start=pool_tasks.refuse) as pool:
        pool.submit(abs, -1)
        with pytest.raises(ShapeGoogleError, match="the worker processes end before they do anything"):
            pool.finished()
