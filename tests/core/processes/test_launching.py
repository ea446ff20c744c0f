# SPDX-License-Identifier: MIT
"""Starting and ending processes in an orderly way."""

from __future__ import annotations

import os
import signal
import sys

import pytest

from shapegoogle_core.processes.launching import (
    cause_of_death,
    default_jobs,
    launch,
    orderly_end,
    single_threaded,
)


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


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
def test_causes_of_death() -> None:
    assert cause_of_death(3) == "exit code 3"
    assert cause_of_death(-signal.SIGSEGV) == "SIGSEGV"
    assert cause_of_death(-signal.SIGKILL).startswith("SIGKILL: the system ended it")
    assert cause_of_death(-1000) == "signal 1000"


def test_there_is_at_least_one_processor() -> None:
    assert default_jobs() >= 1
