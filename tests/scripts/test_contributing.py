# SPDX-License-Identifier: MIT
"""CONTRIBUTING.md: its steps are followed on a copy of the core."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")

# What a newcomer does with the result, by title of the steps.
USES = {
    "a descriptor": """
import shapegoogle_core as sg
assert sg.ChannelSettings("heights", {"bins": 4}).size == 4
mesh = sg.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
from shapegoogle_core.descriptors import DESCRIPTORS
values = DESCRIPTORS["heights"](mesh, sg.compute_spectrum(mesh, k=2))
assert values[3].argmax() == 5 and values[0].argmax() == 0, values
""",
    "a keypoint detector": """
import shapegoogle_core as sg
mesh = sg.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
assert sg.detect_keypoints(mesh, sg.compute_spectrum(mesh, k=2), "tops").indices.tolist() == [3]
""",
    "a mesh format": """
from pathlib import Path
import shapegoogle_core as sg
lines = ["4", "0 0 0", "1 0 0", "0 1 0", "0 0 1", "4", "1 3 2", "1 2 4", "2 3 4", "1 4 3"]
Path("tetrahedron.tri").write_text("\\n".join(lines))
assert len(sg.read_mesh("tetrahedron.tri").faces) == 4
assert [path.name for path in sg.find_meshes(".")] == ["tetrahedron.tri"]
Path("tetrahedron.tri").write_text("\\n".join(lines[:-1]))
try:
    sg.read_mesh("tetrahedron.tri")
except sg.MeshError as error:
    assert str(error) == "'tetrahedron.tri' should have 10 lines, not 9; export it again", error
else:
    raise AssertionError
""",
    "a kind of evidence": """
import shapegoogle_core as sg
from shapegoogle_core.library.search.evidence.figures import with_kind
from shapegoogle_core.rendering.text import evidence_text
found = with_kind(sg.Evidence("similar"), 0.1, 0.4)
assert evidence_text(found) == "perhaps the same kind"
assert with_kind(sg.Evidence("similar"), 0.1, 0.99).kind == "same kind"
assert sg.Filter(kind="perhaps the same kind").kind == found.kind
""",
    "a language of the add-on": """
import os, pkgutil, runpy
folder = os.path.join(os.environ["PYTHONPATH"], "blender_addon", "translation")
assert {"french", "german"} <= {found.name for found in pkgutil.iter_modules([folder])}
french = runpy.run_path(os.path.join(folder, "french.py"))
assert [french["form"](count) for count in (0, 1, 2)] == [0, 0, 1]
assert {len(forms) for forms in french["COUNTED"].values()} == {2}
""",
}


def steps() -> dict[str, str]:
    """Text of each list of steps by its title."""
    parts = re.split(r"^### … (.+)$", PAGE.partition("## Habits")[0], flags=re.MULTILINE)[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


def follow(text: str, root: Path) -> None:
    """Write the new files, and add the new lines to others below the lines that they stand below."""
    for language, indented in re.findall(r"^   ```(\w+)\n(.*?)^   ```$", text, re.DOTALL | re.MULTILINE):
        block = textwrap.dedent(indented)
        first, _, rest = block.partition("\n")
        if language == "python":
            (root / first.removeprefix("# ")).write_text(rest, encoding="utf-8")
            continue
        assert language == "diff"
        path, above = root / first, ""
        for line in rest.splitlines():
            if line.startswith("+"):
                content = path.read_text(encoding="utf-8")
                path.write_text(content.replace(f"{above}\n", f"{above}\n{line[1:]}\n", 1), encoding="utf-8")
            else:
                assert path.read_text(encoding="utf-8").count(f"\n{line[1:]}\n") == 1, f"{first}: {line[1:]}"
            above = line[1:]


def test_there_are_at_most_ten_steps_each() -> None:
    assert list(steps()) == list(USES)
    for text in steps().values():
        numbers = re.findall(r"^(\d+)\. ", text, re.MULTILINE)
        assert numbers == [str(number) for number in range(1, len(numbers) + 1)]
        assert 1 < len(numbers) <= 10


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the core in which all steps were followed."""
    root = tmp_path_factory.mktemp("copy")
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "shapegoogle_core", root / "shapegoogle_core", ignore=ignored)
    translation = Path("blender_addon", "translation")
    shutil.copytree(ROOT / translation, root / translation, ignore=ignored)
    for text in steps().values():
        follow(text, root)
    return root


@pytest.mark.parametrize("title", USES)
def test_following_the_steps_gives_what_they_promise(title: str, followed: Path, tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(followed), "OMP_NUM_THREADS": "1"}
    run = subprocess.run(
        [sys.executable, "-c", USES[title]],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr


def test_what_the_steps_add_is_clean(followed: Path) -> None:
    files = ["descriptors/heights.py", "keypoints/tops.py", "mesh/io/tri.py", "descriptors/registry.py"]
    files += [
        "keypoints/registry.py",
        "mesh/io/reading.py",
        "library/evidence.py",
        "library/search/evidence/figures.py",
    ]
    paths = [str(followed / "shapegoogle_core" / file) for file in files]
    for command in (["check"], ["format", "--check"]):
        run = subprocess.run(
            [sys.executable, "-m", "ruff", *command, "--config", str(ROOT / "pyproject.toml"), *paths],
            capture_output=True,
            text=True,
            check=False,
        )
        assert run.returncode == 0, run.stdout
