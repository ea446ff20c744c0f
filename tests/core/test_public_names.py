# SPDX-License-Identifier: MIT
"""The package itself: its public names, and how little importing it costs."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

import shapegoogle_core as sg

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "shapegoogle_core"
HEAVY = ("numpy", "scipy", "sklearn", "trimesh", "PIL", "pebble", "tqdm")


def modules_after(*arguments: str) -> set[str]:
    """Top-level modules that a fresh Python has imported when it has run something."""
    run = subprocess.run(
        [sys.executable, "-X", "importtime", *arguments],
        capture_output=True,
        text=True,
        check=True,
    )
    lines = [line for line in run.stderr.splitlines() if line.startswith("import time:")]
    return {line.rpartition("|")[2].strip().partition(".")[0] for line in lines}


@pytest.mark.parametrize("name", sg.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert name in dir(sg)
    assert getattr(sg, name).__name__ == name


def test_no_other_name_is_there() -> None:
    with pytest.raises(AttributeError, match="'shapegoogle_core' has no attribute 'read_meshes'"):
        sg.read_meshes  # type: ignore[attr-defined]  # noqa: B018


def test_a_star_imports_the_public_names() -> None:
    names: dict[str, object] = {}
    exec("from shapegoogle_core import *", names)
    assert set(sg.__all__) == names.keys() - {"__builtins__"}


@pytest.mark.parametrize("package", sorted(path.parent.name for path in CORE.glob("*/__init__.pyi")))
def test_every_name_in_the_stub_of_a_package_is_there(package: str) -> None:
    module = importlib.import_module(f"shapegoogle_core.{package}")
    assert module.__all__
    assert set(module.__all__) <= set(dir(module))
    for name in module.__all__:
        assert getattr(module, name) is not None
        # Importing a module of this name would put it in the place of what the package exports.
        assert not (CORE / package / f"{name}.py").exists()


def test_the_stubs_with_the_names_are_installed() -> None:
    patterns = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"][
        "package-data"
    ]
    package = Path(sg.__file__).parent
    packed = {path for pattern in patterns["shapegoogle_core"] for path in package.glob(pattern)}
    assert set(package.rglob("*.pyi")) <= packed


def test_the_version_is_in_one_place() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    assert "version" not in project["project"]
    assert project["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "shapegoogle_core.__version__"}
    assert metadata.version("shapegoogle-core") == sg.__version__


def test_the_command_runs_where_the_package_is_not_installed(tmp_path: Path) -> None:
    (tmp_path / "shapegoogle_core").symlink_to(Path(sg.__file__).parent, target_is_directory=True)
    result = subprocess.run(
        [sys.executable, "-S", "-m", "shapegoogle_core", "--version"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (result.stdout.strip(), result.stderr) == (f"shapegoogle {sg.__version__}", "")


def test_importing_the_package_imports_nothing_large() -> None:
    assert not modules_after("-c", "import shapegoogle_core").intersection(HEAVY)
    assert not modules_after("-c", "from shapegoogle_core import MeshError").intersection(HEAVY)


@pytest.mark.parametrize("arguments", [["--help"], ["query", "--help"], ["train", "--help"]])
def test_help_imports_nothing_large(arguments: list[str]) -> None:
    assert not modules_after("-m", "shapegoogle_core", *arguments).intersection(HEAVY)


def test_describing_a_shape_does_not_import_scikit_learn() -> None:
    program = """
import shapegoogle_core as sg
vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
sg.load_model().describe(sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
"""
    modules = modules_after("-c", program)
    assert "scipy" in modules
    assert "sklearn" not in modules
