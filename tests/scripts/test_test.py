# SPDX-License-Identifier: MIT
"""The test command, run on a small repository of its own."""

import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

TESTS = """import pytest


def test_plain():
    pass


@pytest.mark.real_data
def test_real():
    pass


@pytest.mark.long
def test_long():
    pass
"""


@pytest.fixture
def small_project(project, environment):
    """Return a repository with three tests, whose `.venv` sees the packages that this test sees."""
    (project / "probe.py").write_text("answer: int = 42\n")
    (project / "test_probe.py").write_text(TESTS)
    python = environment.interpreter(project / ".venv")
    command = [str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    packages = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    (Path(packages) / "outer.pth").write_text(sysconfig.get_path("purelib") + "\n")
    ruff = shutil.which("ruff", path=sysconfig.get_path("scripts"))
    shutil.copy(ruff, python.parent)
    return project


def run_test_command(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(root / "scripts" / "test.py"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=root.parent)


def last_lines(result: subprocess.CompletedProcess[str]) -> list[str]:
    return result.stdout.splitlines()[-2:]


def test_when_all_passes_the_last_line_is_that_of_pytest(small_project):
    result = run_test_command(small_project)
    summary, closing = last_lines(result)
    assert summary == "All passed: ruff check, ruff format, mypy, pytest", result.stdout
    assert closing.startswith("2 passed")
    assert result.returncode == 0


def test_checks_that_fail_are_shown_and_named_and_the_tests_run_all_the_same(small_project):
    (small_project / "probe.py").write_text("import os\n\nanswer: int   = 'x'\n")
    result = run_test_command(small_project, "--fast")
    summary, closing = last_lines(result)
    assert summary == "FAILED: ruff check, ruff format, mypy", result.stdout
    assert closing.startswith("1 passed"), "--fast leaves out real data"
    assert "Incompatible types in assignment" in result.stdout
    assert result.returncode == 1


def test_a_failing_test_is_named_and_other_options_reach_pytest(small_project):
    (small_project / "test_probe.py").write_text(TESTS.replace("pass", "raise ValueError", 1))
    result = run_test_command(small_project, "--long", "-k", "not real")
    summary, closing = last_lines(result)
    assert summary == "FAILED: pytest", result.stdout
    assert closing.startswith("1 failed, 1 passed"), "--long runs the long test"
    assert result.returncode == 1
