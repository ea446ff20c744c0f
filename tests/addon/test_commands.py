# SPDX-License-Identifier: MIT
"""The scripts of a studio's night, as processes: index and query .blend files without a window."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"

pytestmark = pytest.mark.skipif(
    bool(bpy.app.binary_path), reason="tests/extension runs the scripts in a Blender that has the extension"
)


def start(script: str, *arguments: object) -> subprocess.Popen[str]:
    command = [sys.executable, str(SCRIPTS / f"{script}.py"), *map(str, arguments)]
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    )


def run(script: str, *arguments: object) -> tuple[int, str, str]:
    process = start(script, *arguments)
    stdout, stderr = process.communicate(timeout=300)
    return process.returncode, stdout, stderr


@pytest.fixture
def folder(blender: Any, tmp_path: Path) -> Path:
    """One .blend of two objects in a folder below, a copy of it, an empty one and one that is none."""
    folder = tmp_path / "studio"
    (folder / "props").mkdir(parents=True)
    bpy.ops.mesh.primitive_monkey_add()
    bpy.ops.mesh.primitive_torus_add(location=(5, 0, 0))
    for path in (folder / "props" / "two.blend", folder / "copy.blend"):
        bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "materials.blend"), copy=True)
    (folder / "cut.blend").write_bytes((folder / "copy.blend").read_bytes()[:3000])
    return folder


def digests(folder: Path) -> dict[Path, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def test_index_and_query(folder: Path, tmp_path: Path) -> None:
    before = digests(folder)
    library_file = tmp_path / "studio.sglib"
    code, stdout, stderr = run("index_library", folder, "--library", library_file, "--jobs", "1")
    assert code == 1
    assert "4 shapes added from 3 files, 1 input failed" in stdout
    assert stderr.splitlines()[-2] == "1 input failed:"
    assert "'cut.blend' cannot be opened by Blender" in stderr.splitlines()[-1]
    with Library.open(library_file) as library:
        found = {(Path(shape.source).name, shape.object_name) for shape in library.shapes()}
    assert found == {(name, item) for name in ("two.blend", "copy.blend") for item in ("Suzanne", "Torus")}

    (folder / "cut.blend").unlink()
    del before[folder / "cut.blend"]
    code, stdout, _ = run("index_library", folder, "--library", library_file)
    assert (code, stdout.strip()) == (0, "nothing to do: 3 files unchanged; the library has 4 shapes")

    query = folder / "props" / "two.blend"
    code, stdout, stderr = run(
        "query_library", query, tmp_path / "gone.blend", "--library", library_file, "--json", "--top", "2"
    )
    assert code == 1
    monkey, torus, gone = map(json.loads, stdout.strip().splitlines())
    assert (monkey["query"], monkey["object"], torus["object"]) == (str(query), "Suzanne", "Torus")
    assert [match["name"] for match in monkey["matches"]] == ["Suzanne", "Suzanne"]
    # Nobody named it, so its file says more.
    assert [match["name"] for match in torus["matches"]] == ["copy (Torus)", "two (Torus)"]
    assert [match["object_name"] for match in torus["matches"]] == ["Torus", "Torus"]
    assert gone["matches"] == []
    assert "gone.blend" in stderr
    assert digests(folder) == before


@pytest.mark.parametrize("script", ["index_library", "query_library", "paint_signatures"])
def test_usage(script: str) -> None:
    code, stdout, _ = run(script, "--help")
    assert code == 0
    assert stdout.startswith(f"usage: {script}")
    assert "exit codes:" in stdout
    code, _, stderr = run(script)
    assert code == 2
    assert "required" in stderr


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_killed_interrupted_and_resumed(folder: Path, tmp_path: Path) -> None:
    (folder / "cut.blend").unlink()
    for index in range(6):  # each another content, so that each is read
        (folder / f"more{index}.blend").write_bytes((folder / "copy.blend").read_bytes() + bytes(index + 1))
    library_file = tmp_path / "studio.sglib"

    def stop(number: int, wanted: int) -> tuple[int, str]:
        process = start("index_library", folder, "--library", library_file, "--jobs", "1")
        while not library_file.exists() or _source_count(library_file) < wanted:
            assert process.poll() is None, process.communicate()
            time.sleep(0.05)
        if number == signal.SIGINT:
            os.killpg(process.pid, number)  # as Ctrl-C does
        else:
            process.kill()
        _, stderr = process.communicate()
        return process.returncode, stderr

    stop(signal.SIGKILL, 2)
    killed = _source_count(library_file)
    code, stderr = stop(signal.SIGINT, killed + 1)
    assert code == 130
    assert "run the same command again to continue" in stderr
    stored = _source_count(library_file)
    assert 2 <= killed < stored < 9
    code, stdout, _ = run("index_library", folder, "--library", library_file)
    assert code == 0
    new = 9 - stored
    assert f" added from {new} file{'s' * (new > 1)}, {stored} files unchanged" in stdout


def _source_count(library_file: Path) -> int:
    from shapegoogle_core import LibraryError

    try:
        with Library.open(library_file, read_only=True) as library:
            return len(library.sources())
    except LibraryError:  # it is being made just now
        return 0
