# SPDX-License-Identifier: MIT
"""`python -m benchmarks`: the list of subcommands, their help, and what is missing."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import subprocess
import sys

import pytest

from benchmarks import command
from benchmarks.errors import BenchmarkError
from benchmarks.figures.command import FIGURES

Capture = pytest.CaptureFixture[str]

NAMES = [each.name for each in command.COMMANDS]


def missing(monkeypatch: pytest.MonkeyPatch, *names: str) -> None:
    """Let modules seem not to be installed."""
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name in names else found(name))


@pytest.mark.parametrize("name", NAMES)
def test_help_says_what_a_subcommand_measures(
    name: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("skimage")
    pytest.importorskip("jinja2")
    # Whether bpy is installed does not matter for the help text.
    monkeypatch.setattr(command, "check_packages", lambda modules: None)
    with pytest.raises(SystemExit) as caught:
        command.main([name, "--help"])
    assert caught.value.code == 0
    printed = capsys.readouterr().out
    assert f"usage: python -m benchmarks {name}" in printed
    assert f"    python -m benchmarks {name}" in printed


def test_the_list_of_subcommands_imports_no_numpy() -> None:
    code = "import sys; from benchmarks.command import main\ntry: main(['--help'])\nfinally: "
    code += "print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    *lines, numpy = done.stdout.splitlines()
    assert all(any(line.startswith(f"    {name}") for line in lines) for name in NAMES)
    assert numpy == "False"


def test_wrong_usage(capsys: Capture) -> None:
    for arguments in ([], ["speed of light"]):
        with pytest.raises(SystemExit) as caught:
            command.main(arguments)
        assert caught.value.code == 2
        assert "SUBCOMMAND" in capsys.readouterr().err


def test_missing_packages_are_named(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    missing(monkeypatch, "jinja2", "platformdirs", "bpy")
    assert command.main(["retrieval", "--nulls", "anywhere"]) == 2
    printed = capsys.readouterr().err
    assert "needs jinja2, platformdirs; install with: pip install -e '.[benchmark]'" in printed
    assert command.main(["blend-meshes", "anywhere", "--output", "elsewhere"]) == 2
    assert "has no module bpy" in capsys.readouterr().err


def test_an_interrupted_subcommand_says_so(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def interrupt(options: argparse.Namespace) -> int:
        raise KeyboardInterrupt

    pytest.importorskip("skimage")
    monkeypatch.setattr(importlib.import_module("benchmarks.experiments.parts"), "run", interrupt)
    assert command.main(["parts"]) == 130
    assert "python -m benchmarks parts: interrupted" in capsys.readouterr().err


def test_a_figure_with_missing_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("skimage")
    missing(monkeypatch, "bpy", "matplotlib")
    for name in set(FIGURES) - {"keypoints"}:
        assert command.main(["figures", name]) == 2
    with pytest.raises(BenchmarkError, match="needs matplotlib"):
        command.check_packages(("numpy", "matplotlib"))
