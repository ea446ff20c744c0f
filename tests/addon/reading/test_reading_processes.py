# SPDX-License-Identifier: MIT
"""The Blender that reads files: its memory, and its end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import bpy
import pytest

from shapegoogle_core import MeshError
from shapegoogle_core.indexing import ShapeReader
from tests.addon.reading.blend_files import add, save

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits and ends processes so")


def heavy(path: Path) -> Path:
    """Write a small file that Blender makes two million faces of."""
    item = add("Heavy")
    item.modifiers.new("Subdivision", "SUBSURF").levels = 6
    return save(path)


def test_memory(addon: ModuleType, tmp_path: Path) -> None:
    import importlib

    reader = importlib.import_module(f"{addon.__name__}.connections").blend_reader()
    path = heavy(tmp_path / "heavy.blend")
    limited = ShapeReader(replace(reader, memory_limit=300))
    with limited, pytest.raises(MeshError, match=r"'heavy\.blend' needs more than 300 MB"):
        limited.read(path)
    bpy.context.object.modifiers.clear()
    light = save(tmp_path / "light.blend")
    with ShapeReader(replace(reader, memory_limit=300)) as limited:
        assert len(limited.read(light).shapes) == 1


PROGRAM = """
import sys
from shapegoogle_core.indexing import ExternalReader, ShapeReader

print("reads", flush=True)
ShapeReader(ExternalReader(frozenset({".blend"}), tuple(sys.argv[2:]), "Blender")).read(sys.argv[1])
"""


def test_a_reading_blender_does_not_outlive_a_killed_worker(addon: ModuleType, tmp_path: Path) -> None:
    import importlib

    path = heavy(tmp_path / "heavy.blend")
    command = importlib.import_module(f"{addon.__name__}.connections").blend_reader().command
    # Inside a real Blender the core lies among the extension's own packages.
    program = f"import sys; sys.path[:] = {sys.path!r}\n{PROGRAM}"
    worker = subprocess.Popen(
        [sys.executable, "-c", program, str(path), *command], stdout=subprocess.PIPE, start_new_session=True
    )
    assert worker.stdout is not None
    assert worker.stdout.readline() == b"reads\n"
    readers: list[int] = []
    while not readers:
        assert worker.poll() is None
        time.sleep(0.05)
        readers = children(worker.pid)
    reader = Path(f"/proc/{readers[0]}")
    while not writes_shapes(reader):  # it is at work
        assert worker.poll() is None
        time.sleep(0.01)
    os.kill(readers[0], signal.SIGSTOP)  # so that it can neither finish nor notice that its input is closed
    worker.kill()
    worker.communicate()
    for _ in range(3000):  # it ends at once, or never
        if not reader.exists():
            return
        time.sleep(0.02)
    os.kill(readers[0], signal.SIGKILL)
    pytest.fail("the reading Blender goes on")


def writes_shapes(process: Path) -> bool:
    """Whether a reading Blender has opened the file that it writes shapes into."""
    files = []
    for entry in (process / "fd").iterdir():
        with suppress(FileNotFoundError):  # closed meanwhile
            files.append(entry.readlink().name)
    return "shapes.bin" in files


def children(pid: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
