# SPDX-License-Identifier: MIT
"""Runs on a local cluster that are interrupted or killed: nothing older lost, nothing stored twice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel
from tests.core.waiting import interruptible, wait_for_sources, wait_until_gone  # noqa: F401

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(sys.platform == "win32", reason="signals and process groups as on Unix"),
    pytest.mark.usefixtures("interruptible"),
]

FILES = 300


@pytest.fixture
def many(tmp_path: Path, make_mesh: Callable[..., Path]) -> Path:
    """Files of three tasks."""
    for seed in range(FILES):
        make_mesh(tmp_path / "meshes" / f"{seed:03}.off", seed=seed, subdivisions=2)
    return tmp_path / "meshes"


def start(url: str, folder: Path) -> subprocess.Popen[str]:
    """Index a folder with two workers, in a process group of its own."""
    command = [sys.executable, "-m", "shapegoogle_core", "index", str(folder), "--library", url]
    return subprocess.Popen(
        [*command, "--cluster", "local", "--jobs", "2"],
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def interrupt(process: subprocess.Popen[str]) -> None:
    """Press Ctrl-C: the workers receive it as well."""
    os.killpg(process.pid, signal.SIGINT)
    output, errors = process.communicate()
    assert process.returncode == 130, errors
    assert "Traceback" not in output + errors


def kill(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate()


@pytest.mark.parametrize("end", [interrupt, kill])
def test_the_next_run_does_what_is_missing(
    many: Path, postgresql_url: str, model: ShapeModel, end: Callable[[subprocess.Popen[str]], None]
) -> None:
    with Library.open(postgresql_url, model) as library:
        process = start(postgresql_url, many)
        wait_for_sources(library, 3, process)
        end(process)
        wait_until_gone(process.pid)
        before = {shape.source: shape.shape_id for shape in library.shapes()}
        assert 3 <= len(before) < FILES
        again = start(postgresql_url, many)
        output, errors = again.communicate()
        assert again.returncode == 0, errors
        assert f"{FILES - len(before)} shapes added" in output
        after = {shape.source: shape.shape_id for shape in library.shapes()}
        assert sorted(after) == sorted(map(str, many.iterdir()))
        assert len(library) == FILES
        assert before.items() <= after.items()
