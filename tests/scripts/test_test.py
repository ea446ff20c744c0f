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


def last_lines(result: subprocess.CompletedProcess[str]) -> tuple[str, str]:
    """What is said of the runs, and how many tests there were."""
    summary, _, closing = result.stdout.splitlines()[-3:]
    return summary, closing


def test_when_all_passes_the_last_line_counts_the_tests(small_project):
    result = run_test_command(small_project)
    summary, closing = last_lines(result)
    assert summary == "All passed: ruff check, ruff format, mypy, core", result.stdout
    assert closing == "2 passed, 0 failed, 0 skipped"
    assert result.returncode == 0


def test_checks_that_fail_are_shown_and_named_and_the_tests_run_all_the_same(small_project):
    (small_project / "probe.py").write_text("import os\n\nanswer: int   = 'x'\n")
    result = run_test_command(small_project, "--fast")
    summary, closing = last_lines(result)
    assert summary == "FAILED: ruff check, ruff format, mypy", result.stdout
    assert closing == "1 passed, 0 failed, 0 skipped", "--fast leaves out real data"
    assert "Incompatible types in assignment" in result.stdout
    assert result.returncode == 1


def test_a_failing_test_is_named_and_other_options_reach_pytest(small_project):
    (small_project / "test_probe.py").write_text(TESTS.replace("pass", "raise ValueError", 1))
    result = run_test_command(small_project, "--long", "-k", "not real")
    summary, closing = last_lines(result)
    assert summary == "FAILED: core", result.stdout
    assert closing == "1 passed, 1 failed, 0 skipped", "--long runs the long test"
    assert result.returncode == 1


def test_what_cannot_run_here_is_left_out_with_a_reason(test, environment, monkeypatch, tmp_path):
    def refuse(reason):
        def refused(*arguments):
            raise environment.SetupError(reason)

        return refused

    monkeypatch.setattr(environment, "ROOT", tmp_path.resolve())
    for name in ("addon", "extension", "gui"):
        (tmp_path / "tests" / name).mkdir(parents=True)
    monkeypatch.setattr(test.blenders, "prepare", refuse("no Python"))
    monkeypatch.setattr(test.blenders, "find_real_blender", refuse("no Blender"))
    monkeypatch.setattr(test.build_extension, "extension_tool", refuse("no tool"))
    plan = test.Plan([])
    plan.add_core()
    plan.add_bpy(["4.5", "4.2"])
    plan.add_real_blender(tmp_path)
    assert plan.left_out == [
        "the add-on's tests on bpy 4.5: no Python",
        "the add-on's tests on bpy 4.2: no Python",
        "the tests of the built extension: no tool",
        "all tests in a real Blender: no Blender",
    ]
    assert [run.name for run in plan.core] == ["core"]
    assert plan.addon == plan.window == []


@pytest.mark.parametrize("has_xvfb", [True, False])
def test_the_window_is_tested_in_a_real_blender_where_there_is_a_display_to_make(test, monkeypatch, has_xvfb):
    monkeypatch.setattr(test.shutil, "which", lambda name: "Xvfb" if has_xvfb else None)
    plan = test.Plan([])
    plan.add_extension([], ["tests/gui"], {})
    assert plan.window == plan.left_out == [], "without a real Blender, which is said elsewhere"
    plan.add_extension([], ["tests/gui"], {"BLENDER": "blender"})
    if has_xvfb:
        (run,) = plan.window
        assert run.variables == {"BLENDER": "blender"}
    else:
        assert plan.window == []
        assert "need Xvfb" in plan.left_out[0]


def test_an_extension_that_does_not_build_is_a_failure(test, environment, monkeypatch, tmp_path):
    def fail(platform):
        raise environment.SetupError("a fault in the manifest")

    monkeypatch.setattr(test.build_extension, "extension_tool", lambda: ["tool"])
    monkeypatch.setattr(test.build_extension, "build", fail)
    plan = test.Plan([])
    assert plan.build() is None
    assert plan.broken == ["building the extension"]
    assert plan.addon == plan.left_out == []


def test_a_path_restricts_to_the_run_it_belongs_to(small_project):
    result = run_test_command(small_project, "test_probe.py::test_plain", "-k", "tests")
    assert "LEFT OUT" not in result.stdout
    assert last_lines(result)[1] == "0 passed, 0 failed, 0 skipped"
    result = run_test_command(small_project, "test_probe.py::test_plain")
    assert last_lines(result)[1] == "1 passed, 0 failed, 0 skipped"


@pytest.mark.parametrize(
    ("given", "addon", "core"),
    [
        ([], ["tests/addon"], []),
        (["tests"], ["tests/addon"], []),
        (["tests/addon"], ["tests/addon"], None),
        (
            ["tests/addon/test_it.py::test_1", "tests/core"],
            ["tests/addon/test_it.py::test_1"],
            ["tests/core"],
        ),
        (["tests/core/test_it.py"], [], ["tests/core/test_it.py"]),
        (["tests/gui"], [], None),
    ],
)
def test_paths_are_dealt_to_the_runs(test, environment, monkeypatch, tmp_path, given, addon, core):
    monkeypatch.setattr(environment, "ROOT", tmp_path.resolve())
    for name in ("addon", "core", "gui"):
        (tmp_path / "tests" / name).mkdir(parents=True)
        (tmp_path / "tests" / name / "test_it.py").touch()
    paths, others = test.split_paths([*given, "-k", "tests", "--maxfail=1"])
    assert (paths, others) == (given, ["-k", "tests", "--maxfail=1"])
    assert test.paths_for("tests/addon", paths) == addon
    assert test.paths_for_core(paths) == core


@pytest.mark.parametrize(
    ("code", "closing", "counts"),
    [
        (0, "12 passed, 3 skipped, 2 deselected, 1 xfailed in 3.45s", (12, 0, 4)),
        (1, "\x1b[31m1 failed\x1b[0m, \x1b[32m12 passed\x1b[0m, 2 errors in 1.00s (0:00:01)", (12, 3, 0)),
        (5, "no tests ran in 0.01s", (0, 0, 0)),
        (-11, "Segmentation fault", (0, 1, 0)),
        (1, "12 passed in 3.45s", (12, 1, 0)),
    ],
)
def test_tests_are_counted_and_a_crash_is_a_failure(test, code, closing, counts):
    total = test.Outcome(code, closing).counts()
    assert (total["passed"], total["failed"], total["skipped"]) == counts
