# SPDX-License-Identifier: MIT
"""Thousands of damaged files: each is read as a finite mesh, or refused in one plain sentence."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.errors import MeshError, MeshWarning
from shapegoogle_core.mesh import MESH_SUFFIXES, read_mesh
from shapegoogle_core.processes.pool import Pool
from tests.core.mesh.io.mutations import damaged, seeds
from tests.core.sentences import faults

# Every file is below 20 kB, so that none needs this many megabytes or seconds.
MEMORY, SECONDS_EACH = 512, 2.0


def read_damaged(first: int, count: int, folder: Path) -> list[str]:
    """Read damaged files and describe everything that went wrong; runs in a process of its own."""
    wrong = []
    for name, data in damaged(first, count, MESH_SUFFIXES):
        path = folder / name
        path.write_bytes(data)
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            try:
                mesh = read_mesh(path)
                if not np.isfinite(mesh.vertices).all():
                    wrong.append(f"{name} has vertices that are not finite")
                if len(mesh.faces) and not 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices):
                    wrong.append(f"{name} has faces without vertices")
            except MeshError as error:
                wrong += [f"{name} {fault}" for fault in faults(str(error), name)]
                if "uses a feature that cannot be read" in str(error):
                    wrong.append(f"{name} is refused without a reason: {error.__cause__!r}")
                if "memory" in str(error):
                    wrong.append(f"{name} took too much memory: {error}")
            except Exception as error:
                wrong.append(f"{name} raised {type(error).__name__}: {error}")
        for warning in warned:
            if issubclass(warning.category, MeshWarning):
                wrong += [f"{name} {fault}" for fault in faults(str(warning.message), name)]
            else:
                wrong.append(f"{name} warned: {warning.message}")
        path.unlink()
    return wrong


def check(count: int, jobs: int, chunk: int, folder: Path) -> None:
    # A task that hangs is killed and fails; its number says which files it was.
    with Pool(jobs, SECONDS_EACH * chunk, memory_limit=MEMORY) as pool:
        tasks = [pool.submit(read_damaged, first, chunk, folder) for first in range(0, count, chunk)]
        while len(pool):
            pool.finished()
        wrong = [line for task in tasks for line in task.result()]
    assert not wrong, f"{len(wrong)} faults:\n" + "\n".join(wrong[:100])


def test_the_undamaged_files_can_be_read(tmp_path: Path) -> None:
    for name, data in seeds().items():
        if name.startswith("corpus-") or Path(name).suffix not in MESH_SUFFIXES:
            continue  # those of the corpus have a test of their own, and some are refused
        path = tmp_path / name
        path.write_bytes(data)
        assert len(read_mesh(path).vertices) >= 8


def test_some_damaged_files(tmp_path: Path) -> None:
    check(300, jobs=1, chunk=300, folder=tmp_path)


@pytest.mark.long
def test_ten_thousand_damaged_files(tmp_path: Path) -> None:
    check(10_000, jobs=2, chunk=250, folder=tmp_path)
