# SPDX-License-Identifier: MIT
"""Finding Pythons and Blenders for the sessions, and the reasons for refusing them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import nox
import pytest
from nox.command import CommandFailed

import noxfile


def make_program(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def empty_machine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A machine without Blender, and without any Python but the running one."""
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path / "pyenv"))
    monkeypatch.delenv("BLENDER", raising=False)
    return tmp_path


@pytest.mark.usefixtures("empty_machine")
def test_the_running_python_is_taken_without_a_search() -> None:
    assert noxfile.find_python("{}.{}".format(*sys.version_info[:2])) == sys.executable


@pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")
def test_a_python_is_found_only_if_it_runs_and_is_what_its_name_says(empty_machine: Path) -> None:
    versions = empty_machine / "pyenv" / "versions"
    assert noxfile.find_python("3.99") is None
    make_program(empty_machine / "bin" / "python3.99", "echo 'command not found' >&2; exit 127")
    assert noxfile.find_python("3.99") is None, "as the files that pyenv has on PATH"
    make_program(versions / "3.99.1" / "bin" / "python3.99", "echo 3.98")
    assert noxfile.find_python("3.99") is None
    right = make_program(versions / "3.99.0" / "bin" / "python3.99", "echo 3.99")
    assert noxfile.find_python("3.99") == str(right)


def test_the_probe_reports_what_cannot_be_imported() -> None:
    # There is no bpy in the environment of the core.
    command = [sys.executable, "-c", noxfile.BPY_PROBE]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert "No module named 'bpy'" in result.stderr


@pytest.mark.parametrize(
    ("codes", "runs", "fails"),
    [((0,), 1, False), ((1,), 1, True), ((-11, 0), 2, False), ((-11, -11), 2, True), ((-11, 1), 2, True)],
)
def test_only_a_crash_of_the_module_is_tried_again(codes: tuple[int, ...], runs: int, fails: bool) -> None:
    left, warnings = list(codes), list[str]()

    def run(*command: str, env: dict[str, str]) -> None:
        nox.command.run(
            [
                sys.executable,
                "-c",
                f"import os, signal; code = {left.pop(0)}\n"
                "os.kill(os.getpid(), -code) if code < 0 else os._exit(code)",
            ],
            external=True,
        )

    session: Any = SimpleNamespace(run=run, warn=warnings.append)
    with pytest.raises(CommandFailed) if fails else nullcontext():
        noxfile.run_in_module(session, "script.py")
    assert len(codes) - len(left) == runs
    assert len(warnings) == runs - 1


def test_no_blender_is_a_reason_of_its_own(empty_machine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(noxfile.BlenderMissingError, match="none on PATH or in BLENDER"):
        noxfile.find_real_blender()
    monkeypatch.setenv("BLENDER", str(empty_machine / "absent"))
    with pytest.raises(noxfile.BlenderMissingError, match=r"BLENDER=.*absent is not a program"):
        noxfile.find_real_blender()


@pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")
@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        ("[[3, 4, 1], [3, 11], true]", "Blender 3.4.1, older than 4.2"),
        (None, "does not report its Python"),
    ],
)
def test_an_unusable_blender_is_refused(empty_machine: Path, answer: str | None, reason: str) -> None:
    text = f"echo 'Blender starts'; echo 'shape-google {answer}'" if answer else "echo broken"
    make_program(empty_machine / "bin" / "blender", text)
    with pytest.raises(noxfile.BlenderMissingError, match=re.escape(reason)):
        noxfile.find_real_blender()


@pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")
def test_a_blender_is_asked_for_its_versions(empty_machine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = "echo 'shape-google [[5, 0, 1], [3, 11], false]'"
    command = make_program(empty_machine / "elsewhere" / "blender", text)
    monkeypatch.setenv("BLENDER", str(command))
    assert noxfile.find_real_blender() == noxfile.RealBlender(str(command), "5.0.1", "3.11", False)


def test_every_blender_has_a_session_and_a_numpy() -> None:
    for series, versions in noxfile.BLENDERS.items():
        assert versions["bpy"].startswith(f"{series}.")
        assert set(versions) == {"bpy", "numpy", "python"}


def test_options_of_a_session_name_its_folder_unless_tests_are_named() -> None:
    assert noxfile.pytest_options(["-k", "heat"], "tests/addon") == ["--quiet", "-k", "heat", "tests/addon"]
    named = noxfile.pytest_options(["tests/addon/test_it.py::test_1"], "tests/addon")
    assert named == ["--quiet", "tests/addon/test_it.py::test_1"]


def test_what_python_compiles_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    command = [sys.executable, "-c", "import sys; print(sys.dont_write_bytecode)"]
    result = subprocess.run(
        command, env=os.environ | noxfile.ENVIRONMENT, capture_output=True, text=True, check=True
    )
    assert result.stdout == "False\n"


def test_sessions_at_once_install_the_modules_of_a_blender_once(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(noxfile, "MODULES", tmp_path)
    python = noxfile.BLENDERS["5.2"]["python"]
    blender = noxfile.RealBlender("blender", "5.2.3", python, has_numpy=True)
    installed: list[Path] = []

    def run(*command: str, external: bool) -> None:
        folder = Path(command[command.index("--target") + 1])
        installed.append(folder)
        (folder / "numpy").mkdir(parents=True)
        time.sleep(0.1)  # the others come meanwhile
        (folder / "scipy").mkdir()

    with ThreadPoolExecutor(3) as pool:
        session: Any = SimpleNamespace(run=run)
        (folder,) = {*pool.map(lambda _: noxfile.install_modules(session, blender), range(3))}
    assert installed == [folder]
    assert sorted(path.name for path in folder.iterdir()) == ["requirements.txt", "scipy"]
