# SPDX-License-Identifier: MIT
"""Another program: messages, what else it prints, time limits, and how it ends."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import pytest

from shapegoogle_core.processes import program as program_module
from shapegoogle_core.processes import signs_of_life
from shapegoogle_core.processes.program import Program

START = """
import json, os, signal, sys, time
from shapegoogle_core.processes.messages import MessageWriter, claim_message_pipe
pipe = claim_message_pipe()
write = MessageWriter(pipe).write
"""

# Answers each request; some words make it misbehave.
ECHO = """
print("a banner", flush=True)
for line in sys.stdin:
    word = json.loads(line)
    print("noise", file=sys.stderr, flush=True)
    if word == "hang":
        time.sleep(3600)
    if word == "talk":
        for stream in (1, 2):
            os.write(stream, b"x" * 2**20 + bytes(range(256)) + b"\\n")
    if word == "die":
        print("something is wrong", flush=True)
        os._exit(3)
    if word == "die in a message":
        pipe.write(b'{"answer": "a lon')
        os._exit(3)
    if word == "nonsense":
        pipe.write(b"Blender quit\\n")
    if word == "close":
        pipe.close()
        time.sleep(3600)
    write({"answer": word})
print("the end")
"""

# What breaks lines, or looks like the end of a message.
NAMES = ["a\nb", "a\r\nb", "a\u2028b\u2029c\x85d", "\udcff\udc80", "}{\x00\x1b[31m\u202eabc", "Pferd ä 🐎"]


def start(code: str, with_input: bool = True) -> Program:
    return Program([sys.executable, "-c", START + code], with_input=with_input)


def test_messages_and_what_it_prints() -> None:
    program = start(ECHO)
    for word in ["horse", *NAMES, "talk", {"huge": "ä" * 5_000_000}]:
        program.send(word)
        assert program.message() == {"answer": word}
    running = program.exit_code is None
    assert running
    assert program.close() == 0
    assert program.exit_code == 0
    assert program.last_lines(2) == "noise; the end"


@pytest.mark.parametrize("word", ["die", "die in a message"])
def test_a_program_that_dies(word: str) -> None:
    program = start(ECHO)
    program.send(word)
    assert program.message() is None
    assert program.ending(1).startswith("exit code 3: ")
    # Whoever asks it again learns the same.
    program.send("horse")
    assert program.message() is None
    assert program.close() == 3


def test_a_program_that_sends_nonsense_is_ended() -> None:
    program = start(ECHO)
    program.send("nonsense")
    assert program.message() is None
    assert program.close() != 0


def test_a_program_that_only_closes_its_messages_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shapegoogle_core.processes.program.PATIENCE", 0.1)
    program = start(ECHO)
    program.send("close")
    assert program.message() is None
    assert "SIGKILL" in program.ending(1) or sys.platform == "win32"


def test_a_program_that_hangs_is_killed() -> None:
    program = start(ECHO)
    program.send("horse")
    assert program.message() == {"answer": "horse"}
    program.send("hang")
    with pytest.raises(TimeoutError, match="no message within"):
        program.message(time_limit=0.5)
    assert program.wait() != 0


def test_closing_a_program_that_has_ended() -> None:
    program = start("raise SystemExit(4)")
    program.wait()
    assert program.close() == 4


def test_watching_until_the_end() -> None:
    program = start("[write(number) for number in range(3)]; print('done'); sys.exit(1)", with_input=False)
    assert list(program.messages()) == [0, 1, 2]
    assert program.wait() == 1
    assert program.last_lines(5) == "done"


def test_threads_share_a_pipe() -> None:
    code = """
from threading import Thread
threads = [Thread(target=write, args=([number] * 50_000,)) for number in range(8)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
"""
    program = start(code, with_input=False)
    messages = sorted(program.messages())
    assert messages == [[number] * 50_000 for number in range(8)]
    assert program.close() == 0


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM")
def test_a_program_that_is_terminated_can_clean_up() -> None:
    code = (
        "def end(*_): write('cleaned'); sys.exit(5)\n"
        "signal.signal(signal.SIGTERM, end)\n"
        "write('ready')\n"
        "time.sleep(3600)\n"
    )
    program = start(code, with_input=False)
    assert program.message() == "ready"
    messages: list[object] = []
    reader = threading.Thread(target=lambda: messages.extend(program.messages()))
    reader.start()
    assert program.terminate() == 5
    reader.join()
    assert messages == ["cleaned"]


def test_a_program_that_cannot_be_started(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        Program([str(tmp_path / "none")])


def test_environment() -> None:
    code = """
import json, os
with open(int(os.environ["SHAPEGOOGLE_MESSAGES"]), "w") as messages:
    print(json.dumps(os.environ["WORD"]), file=messages)
"""
    program = Program([sys.executable, "-c", code], environment={"WORD": "horse", "SYSTEMROOT": ""})
    assert list(program.messages()) == ["horse"]
    program.close()


@pytest.mark.parametrize("end", ["close", "terminate", "wait"])
def test_temporary_files_do_not_outlast_it(tmp_path: Path, end: str) -> None:
    code = "import tempfile; write(tempfile.mkdtemp()); os.kill(os.getpid(), signal.SIGKILL)"
    program = Program([sys.executable, "-c", START + code], with_input=True, within=tmp_path)
    assert tmp_path in Path(program.message()).parents
    getattr(program, end)()
    assert not list(tmp_path.iterdir())


# Works for some seconds of its own, however long they take, before it says anything.
BUSY = """
while time.process_time() < 3:
    pass
write("ready")
"""


def test_a_program_that_works_is_waited_for_and_one_that_does_nothing_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Time passes a hundred times as fast for the one who waits, as if the machine were that busy."""
    monkeypatch.setattr(program_module, "SECONDS_BETWEEN_LOOKS", 0.2)
    monkeypatch.setattr(signs_of_life, "LEAST_WORK", 0.01)
    monkeypatch.setattr(
        program_module, "Silence", partial(signs_of_life.Silence, clock=lambda: 100 * time.monotonic())
    )
    busy = start(BUSY)
    assert busy.message(patience=200.0) == "ready"
    busy.close()
    idle = start("time.sleep(3600)")
    with pytest.raises(TimeoutError):
        idle.message(patience=200.0)
    idle.close()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not tell")
def test_what_a_process_has_worked_counts_its_children() -> None:
    code = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'while True: pass'])"
    process = subprocess.Popen([sys.executable, "-c", code], start_new_session=True)
    try:
        # Python alone starts in a fraction of that.
        while (signs_of_life.processor_seconds(process.pid) or 0.0) < 2:
            time.sleep(0.05)
    finally:
        os.killpg(process.pid, 9)
        process.wait()
