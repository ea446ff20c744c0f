# SPDX-License-Identifier: MIT
"""Starting and ending processes in an orderly way."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time

import pytest

from shapegoogle_core.processes.launching import (
    cause_of_death,
    default_jobs,
    interrupts_blocked,
    launch,
    orderly_end,
    single_threaded,
)
from tests.core.waiting import interruptible  # noqa: F401


def test_processes_compute_on_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    # A number that the user chose stays.
    monkeypatch.setenv("MKL_NUM_THREADS", "3")
    with single_threaded():
        code = "import os; print(os.environ['OMP_NUM_THREADS'], os.environ['MKL_NUM_THREADS'])"
        process, messages = launch([sys.executable, "-c", code], with_input=False)
        output, _ = process.communicate()
        messages.close()
    assert output.split() == [b"1", b"3"]
    assert "OMP_NUM_THREADS" not in os.environ
    assert os.environ["MKL_NUM_THREADS"] == "3"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM")
def test_sigterm_acts_as_control_c() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt), orderly_end():
        signal.raise_signal(signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) == before


@pytest.mark.skipif(sys.platform == "win32", reason="the signals of Unix")
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_start_is_not_interrupted_through_another_thread(name: str) -> None:
    number = getattr(signal, name)
    is_over = threading.Event()
    thread = threading.Thread(target=is_over.wait)  # blocks no signals
    thread.start()
    steps = []

    def start_a_process() -> None:
        with orderly_end(), interrupts_blocked():
            for step in range(20):
                signal.pthread_kill(thread.ident or 0, number)
                time.sleep(0.01)  # where Python would call the handler
                steps.append(step)

    try:
        with pytest.raises(KeyboardInterrupt):
            start_a_process()
    finally:
        is_over.set()
        thread.join()
    assert len(steps) == 20


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
def test_causes_of_death() -> None:
    assert cause_of_death(3) == "exit code 3"
    assert cause_of_death(-signal.SIGSEGV) == "SIGSEGV"
    assert cause_of_death(-signal.SIGKILL).startswith("SIGKILL: the system ended it")
    assert cause_of_death(-1000) == "signal 1000"


def test_there_is_at_least_one_processor() -> None:
    assert default_jobs() >= 1
