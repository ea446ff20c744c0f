# SPDX-License-Identifier: MIT
"""Whatever ends a command, it leaves no processes and no temporary files."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.core.cli.running import StartShapegoogle
from tests.core.number_reader import PROGRAM
from tests.core.waiting import interruptible, wait_until_gone  # noqa: F401

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="signals and process groups as on Unix"),
    pytest.mark.usefixtures("interruptible"),
]

# The command with a program that reads files of numbers.
WITH_READER = """
import sys
from pathlib import Path
from shapegoogle_core.cli import main
from shapegoogle_core.indexing import ExternalReader, ReaderOption

if __name__ == "__main__":
    program, *arguments = sys.argv[1:]
    offers = (ReaderOption("prefix", ("x",), "what names begin with"),)
    command = (sys.executable, program)
    sys.exit(main(arguments, reader=ExternalReader(frozenset({".numbers"}), command, "the program", offers)))
"""


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setenv("TMPDIR", str(place))
    return place


@pytest.fixture
def hanging(tmp_path: Path) -> Path:
    """A file over which the program that reads it hangs; it leaves a mark beside it first."""
    (tmp_path / "program.py").write_text(
        PROGRAM.replace("time.sleep(3600)", "open(request['path'] + '.mark', 'w').close(); time.sleep(3600)")
    )
    (tmp_path / "script.py").write_text(WITH_READER)
    path = tmp_path / "files" / "hangs.numbers"
    path.parent.mkdir()
    path.write_text("hang")
    return path


def wait_for(condition: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    while not condition():
        assert process.poll() is None, "the command ended too early"
        time.sleep(0.05)


@pytest.mark.parametrize(
    ("command", "number", "group"),
    [
        ("index", "SIGHUP", True),
        ("query", "SIGINT", True),
        ("query", "SIGTERM", False),
        pytest.param("train", "SIGHUP", True, marks=pytest.mark.long),
    ],
)
@pytest.mark.usefixtures("indexed")
def test_while_another_program_reads(
    command: str, number: str, group: bool, hanging: Path, temporary: Path, tmp_path: Path, library_file: Path
) -> None:
    rest = ("--output", tmp_path / "model.npz") if command == "train" else ("--library", library_file)
    inputs = hanging if command == "query" else hanging.parent
    arguments = [sys.executable, tmp_path / "script.py", tmp_path / "program.py", command, inputs, *rest]
    process = subprocess.Popen(
        list(map(str, arguments)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[3]), "OMP_NUM_THREADS": "1"},
    )
    wait_for(Path(f"{hanging}.mark").exists, process)
    assert list(temporary.iterdir())
    (os.killpg if group else os.kill)(process.pid, getattr(signal, number))
    _, stderr = process.communicate()
    assert process.returncode == 130
    assert "interrupted" in stderr
    assert "Traceback" not in stderr
    wait_until_gone(process.pid)
    assert list(temporary.iterdir()) == []


@pytest.mark.parametrize(
    ("number", "group"), [("SIGINT", True), pytest.param("SIGKILL", False, marks=pytest.mark.long)]
)
def test_while_processes_train(
    number: str,
    group: bool,
    temporary: Path,
    tmp_path: Path,
    make_mesh: Callable[..., Path],
    start_shapegoogle: StartShapegoogle,
) -> None:
    for seed in range(9):
        make_mesh(tmp_path / "many" / f"{seed}.off", seed=seed, subdivisions=4)
    process = start_shapegoogle("train", tmp_path / "many", "--output", tmp_path / "model.npz", "--jobs", "2")
    assert process.stderr is not None
    while not process.stderr.readline().startswith("descriptors"):
        assert process.poll() is None, "the command ended too early"
    time.sleep(3)  # the processes start now
    (os.killpg if group else os.kill)(process.pid, getattr(signal, number))
    _, stderr = process.communicate()
    assert process.returncode == (-9 if number == "SIGKILL" else 130)
    assert "Traceback" not in stderr
    wait_until_gone(process.pid)
    assert list(temporary.iterdir()) == []
    assert not (tmp_path / "model.npz").exists()
