# SPDX-License-Identifier: MIT
"""The test command: which sessions it runs, and its exit code."""

from __future__ import annotations

from itertools import chain
from types import ModuleType

import pytest

ADDON = ["addon-4.5"]
PREPARED = [["addon-4.5 --install-only"], ["build"]]


@pytest.mark.parametrize(
    ("paths", "stages"),
    [
        ([], [*PREPARED, ["window", *ADDON, "core", "checks", "extension"]]),
        (["tests/addon"], [[name] for name in ADDON]),
        (["tests/addon/test_it.py::test_1", "tests/core"], [["core"], *([name] for name in ADDON)]),
        (["tests/core/test_it.py"], [["core"]]),
        (["tests/extension", "tests/gui"], [["extension"], ["window"]]),
    ],
)
def test_paths_choose_the_sessions(
    test_script: ModuleType, paths: list[str], stages: list[list[str]]
) -> None:
    assert test_script.sessions_for(paths) == stages


def test_more_blenders_are_tested_on_request(test_script: ModuleType) -> None:
    assert test_script.CI == ("blender", "addon-4.5", "addon-4.2")
    assert (*test_script.CI, "addon-5.0", "addon-5.2") == test_script.ALL
    environments, build, sessions = test_script.sessions_for([], test_script.CI)
    assert environments == ["addon-4.5 --install-only", "addon-4.2 --install-only"]
    assert build == ["build"]
    assert sessions == ["window", *test_script.CI, "core", "checks", "extension"]
    documented = test_script.sessions_for([], test_script.CI, docs=True)[-1]
    assert documented == ["window", *test_script.CI, "core", "checks", "docs", "extension"]
    assert test_script.sessions_for(["tests/addon"], test_script.CI) == [[name] for name in test_script.CI]


@pytest.mark.parametrize("failing", [None, "core", "addon-4.5"])
def test_one_failing_session_fails_the_run_and_the_others_still_run(
    test_script: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    failing: str | None,
) -> None:
    ran: list[str] = []

    def run(name: str, *, options: list[str], live: bool) -> bool:
        ran.append(name)
        assert options[:2] == ["-m", "not long and not real_data"]
        assert live == (name == "core" or [name] in PREPARED)
        return name != failing

    monkeypatch.setattr(test_script.bootstrap, "enter", lambda extras: None)
    monkeypatch.setattr(test_script, "run_session", run)
    assert test_script.main(["--fast"]) == (0 if failing is None else 1)
    assert sorted(ran) == sorted([*chain(*PREPARED), "checks", "core", *ADDON, "extension", "window"])
    closing = capsys.readouterr().out.splitlines()[-1]
    assert closing.endswith("all passed" if failing is None else f"FAILED: {failing}")


def test_a_session_of_nox_passes_its_options_to_pytest(
    test_script: ModuleType, capfd: pytest.CaptureFixture[str]
) -> None:
    # In one process: there is one test to run.
    nothing = [
        "--numprocesses=0",
        "--dist=no",
        "-m",
        "",
        "tests/scripts/test_wheels.py",
        "-k",
        "another_platform",
    ]
    assert test_script.run_session("core", options=nothing, live=False)
    assert "1 passed" in capfd.readouterr().out
    assert not test_script.run_session("core", options=[*nothing, "--no-such-option"], live=False)
