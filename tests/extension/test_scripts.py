# SPDX-License-Identifier: MIT
"""The scripts and the command in a real Blender, without the extension and with it."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
MAKE = """
import bpy, sys
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
bpy.ops.mesh.primitive_monkey_add()
bpy.ops.mesh.primitive_torus_add(location=(5, 0, 0))
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1])
"""


@pytest.fixture(scope="module")
def blender(host: Any) -> Any:
    if not host.is_real:
        pytest.skip("Blender as a Python module runs the scripts in tests/addon")

    def run(*arguments: Any) -> Any:
        return subprocess.run(
            [host.command[0], *map(str, arguments)],
            cwd=ROOT,
            env={**os.environ, **host.variables, "BLENDER_USER_RESOURCES": str(host.user_folder)},
            capture_output=True,
            text=True,
            errors="replace",
            timeout=300,
            check=False,
        )

    return run


def records(output: Any) -> Any:
    return [json.loads(line) for line in output.splitlines() if line.startswith("{")]


def test_the_whole_way(blender: Any, extension: Any, tmp_path: Path) -> None:
    folder = tmp_path / "my assets"
    folder.mkdir()
    (tmp_path / "make.py").write_text(MAKE)
    blender("-b", "-P", tmp_path / "make.py", "--", folder / "two shapes.blend")
    (folder / "broken.blend").write_bytes(b"no Blender file")
    before = (folder / "two shapes.blend").read_bytes()
    library = tmp_path / "shapes.sglib"

    for script in ("index_library", "query_library", "paint_signatures"):
        missing = blender("-b", "-P", SCRIPTS / f"{script}.py", "--", folder, "--library", library)
        assert missing.returncode == 2
        assert "is not installed in this Blender" in missing.stderr
    # The line that it gives, with the zip's real name.
    line = missing.stderr.partition("install it with: ")[2].splitlines()[0]
    _, *arguments = shlex.split(line)
    *options, name = arguments
    assert name.endswith(".zip")
    installed = blender(*options, extension)
    assert installed.returncode == 0, installed.stderr

    index = ("-b", "-P", SCRIPTS / "index_library.py", "--", folder, "--library", library, "--jobs", "1")
    first = blender(*index)
    assert first.returncode == 1
    assert "2 shapes added from 1 file, 1 input failed" in first.stdout
    assert "'broken.blend' cannot be opened by Blender" in first.stderr
    (folder / "broken.blend").unlink()
    second = blender(*index)
    assert second.returncode == 0
    assert "nothing to do: 1 file unchanged; the library has 2 shapes" in second.stdout

    query = (folder / "two shapes.blend", "--library", library, "--json", "--top", "1")
    by_script = blender("-b", "-P", SCRIPTS / "query_library.py", "--", *query)
    json_lines = [json.loads(line) for line in by_script.stdout.splitlines()]
    assert json_lines == records(by_script.stdout), "nothing but JSON, though Blender prints a banner"
    by_command = blender("--command", "shape_google", "query", *query)
    assert by_script.returncode == by_command.returncode == 0
    assert records(by_script.stdout) == records(by_command.stdout)
    assert [(record["object"], record["matches"][0]["name"]) for record in records(by_script.stdout)] == [
        ("Suzanne", "Suzanne"),
        ("Torus", "two shapes (Torus)"),
    ]
    painted = blender(
        "--command",
        "shape_google",
        "paint",
        folder / "two shapes.blend",
        "--output",
        tmp_path / "painted.blend",
    )
    assert painted.returncode == 0, painted.stderr
    assert (tmp_path / "painted.blend").stat().st_size > len(before)
    assert (folder / "two shapes.blend").read_bytes() == before
