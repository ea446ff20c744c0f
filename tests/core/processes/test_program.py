# SPDX-License-Identifier: MIT
"""Another program: messages, other lines, time limits, and how it ends."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

import pytest

from shapegoogle_core.processes.program import Program

# Answers each line; some words make it misbehave.
ECHO = """
import os, sys, time
print("a banner", flush=True)
for line in sys.stdin:
    word = line.strip()
    print("noise", file=sys.stderr, flush=True)
    if word == "hang":
        time.sleep(3600)
    if word == "die":
        print("something is wrong", flush=True)
        os._exit(3)
    print("answer", word, flush=True)
print("the end")
"""


def start(code: str, marker: str = "answer ", with_input: bool = True) -> Program:
    return Program([sys.executable, "-c", code], marker=marker, with_input=with_input)


def test_messages_and_other_lines() -> None:
    program = start(ECHO)
    for word in ("horse", "Pferd ä"):
        program.send(word)
        assert program.message() == word
    running = program.exit_code is None
    assert running
    assert program.close() == 0
    assert program.exit_code == 0
    assert list(program.other_lines)[:3] == ["a banner", "noise", "noise"]
    assert program.last_lines(2) == "noise; noise"


def test_a_program_that_dies() -> None:
    program = start(ECHO)
    program.send("die")
    assert program.message() is None
    assert program.wait() == 3
    assert program.last_lines(2) == "noise; something is wrong"
    # Whoever asks it again learns the same.
    program.send("horse")
    assert program.message() is None
    assert program.close() == 3


def test_a_program_that_hangs_is_killed() -> None:
    program = start(ECHO)
    program.send("horse")
    assert program.message() == "horse"
    program.send("hang")
    with pytest.raises(TimeoutError, match="no message within"):
        program.message(time_limit=0.5)
    assert program.wait() != 0


def test_closing_a_program_that_has_ended() -> None:
    program = start("raise SystemExit(4)")
    program.wait()
    assert program.close() == 4


def test_watching_until_the_end() -> None:
    code = "import sys; [print('answer', number) for number in range(3)]; print('done'); sys.exit(1)"
    program = start(code, with_input=False)
    assert list(program.messages()) == ["0", "1", "2"]
    assert program.wait() == 1
    assert list(program.other_lines) == ["done"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM")
def test_a_program_that_is_terminated_can_clean_up() -> None:
    code = (
        "import signal, sys, time\n"
        "def end(*_): print('answer cleaned', flush=True); sys.exit(5)\n"
        "signal.signal(signal.SIGTERM, end)\n"
        "print('answer ready', flush=True)\n"
        "time.sleep(3600)\n"
    )
    program = start(code, with_input=False)
    assert program.message() == "ready"
    messages: list[str] = []
    reader = threading.Thread(target=lambda: messages.extend(program.messages()))
    reader.start()
    assert program.terminate() == 5
    reader.join()
    assert messages == ["cleaned"]


def test_a_program_that_cannot_be_started(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        Program([str(tmp_path / "none")], marker="")


def test_environment() -> None:
    program = Program(
        [sys.executable, "-c", "import os; print('answer', os.environ.get('WORD'))"],
        marker="answer ",
        environment={"WORD": "horse", "SYSTEMROOT": ""},
    )
    assert list(program.messages()) == ["horse"]
