# SPDX-License-Identifier: MIT
"""The command as users start it, and small libraries to try it on."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator

import pytest

from shapegoogle_core.cli import main
from tests.core.cli.running import Command, Shapegoogle, StartShapegoogle, start, without_progress
from tests.core.number_reader import reader  # noqa: F401
from tests.core.small_libraries import folder, indexed, library, library_file, model_file  # noqa: F401
from tests.core.tiny_model import model  # noqa: F401


@pytest.fixture(scope="session")
def shapegoogle() -> Shapegoogle:
    """Run the command to its end."""

    def run(*arguments: object) -> subprocess.CompletedProcess[str]:
        process = start(*arguments)
        stdout, stderr = process.communicate()
        return subprocess.CompletedProcess(process.args, process.returncode, stdout, without_progress(stderr))

    return run


@pytest.fixture
def start_shapegoogle() -> Iterator[StartShapegoogle]:
    """Start the command; what still runs at the end of the test is killed."""
    processes: list[subprocess.Popen[str]] = []

    def run(*arguments: object) -> subprocess.Popen[str]:
        processes.append(start(*arguments))
        return processes[-1]

    yield run
    for process in processes:
        process.kill()
        process.communicate()


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Command:
    """Run the command in this process."""

    def call(*arguments: object) -> tuple[int, str, str]:
        capsys.readouterr()
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as exit:  # argparse
            code = exit.code if isinstance(exit.code, int) else 1
        printed = capsys.readouterr()
        return code, printed.out, without_progress(printed.err)

    return call
