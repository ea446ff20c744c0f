# SPDX-License-Identifier: MIT
"""The built zips, and the Blenders to install them in: `scripts/test.py` makes both and names them."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from lib.wheels import python_tag

ROOT = Path(__file__).resolve().parents[2]
MARK = "shape-google-report "
# All that a Blender has of Python packages: its own ones, but none of those that the extension brings along.
OWN_PACKAGES: tuple[str, ...] = (
    "bpy",
    "lib",
    "numpy",
    "numpy.libs",
    "requests",
    "urllib3",
    "certifi",
    "idna",
)
OWN_PACKAGES += (
    "charset_normalizer",
    "zstandard",
    "attr",
    "attrs",
    "cattr",
    "cattrs",
    "typing_extensions.py",
)


@dataclass(frozen=True)
class Host:
    """A Blender with a user folder of its own, in which nothing but the extension can be found."""

    command: tuple[str, ...]
    variables: dict[str, str]
    user_folder: Path
    python_tag: str

    @property
    def is_real(self) -> bool:
        """Whether it is a program, not a Python module."""
        return "--python" in self.command

    def run(self, *arguments: str | Path, command: tuple[str, ...] | None = None) -> str:
        """Run a Python script in it, or another command line of it, and return what it prints."""
        result = subprocess.run(
            [*(command or self.command), *map(str, arguments)],
            cwd=ROOT,
            env={**os.environ, **self.variables, "BLENDER_USER_RESOURCES": str(self.user_folder)},
            capture_output=True,
            text=True,
            errors="replace",
            timeout=300,
            check=False,
        )
        output = result.stdout + result.stderr
        assert result.returncode == 0, f"exit code {result.returncode}\n{output}"
        return output

    def report(self, script: Path, *arguments: str | Path) -> dict[str, Any]:
        """Run a script in it, and return the report that it prints."""
        separator = ("--",) if self.is_real else ()
        output = self.run(script, *separator, *arguments)
        lines = [line for line in output.splitlines() if line.startswith(MARK)]
        assert len(lines) == 1, output
        report: dict[str, Any] = json.loads(lines[0].removeprefix(MARK))
        return {**report, "output": output}


def real_blender(user_folder: Path) -> Host:
    """The Blender that BLENDER names; one without numpy gets it, as people must give it one too."""
    modules = user_folder / "scripts" / "modules"
    modules.mkdir(parents=True)
    for package in Path(os.environ["SHAPEGOOGLE_BLENDER_MODULES"]).glob("numpy*"):
        (modules / package.name).symlink_to(package)
    command = (os.environ["BLENDER"], "--background", "--python-exit-code", "1", "--python")
    # The folder's name ends in Blender's Python, see `install_modules` in noxfile.py.
    python = Path(os.environ["SHAPEGOOGLE_BLENDER_MODULES"]).name.rpartition("-")[2]
    return Host(command, {}, user_folder, python_tag(python))


def bpy_module(name: str, folder: Path) -> Host:
    """Blender as a Python module, on a path with nothing but Blender's own packages."""
    environment = ROOT / ".nox" / name
    packages = folder / "packages"
    packages.mkdir()
    (site_packages,) = environment.glob("lib/python*/site-packages")
    for package in OWN_PACKAGES:
        if (site_packages / package).exists():
            (packages / package).symlink_to(site_packages / package)
    python = environment / "bin" / "python"
    # -S: without the environment's own packages, which include the core and those that the extension brings.
    version = site_packages.parent.name.removeprefix("python")
    return Host((str(python), "-S"), {"PYTHONPATH": str(packages)}, folder / "user", python_tag(version))


def host_names() -> list[str]:
    names = [path.parent.parent.name for path in sorted((ROOT / ".nox").glob("addon-*/bin/python"))]
    return [*names, "real"] if os.environ.get("BLENDER") else names


@pytest.fixture(scope="module", params=host_names())
def host(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Host:
    folder = tmp_path_factory.mktemp(request.param)
    if request.param == "real":
        return real_blender(folder)
    return bpy_module(request.param, folder)


@pytest.fixture(scope="session")
def extensions() -> dict[str, Path]:
    """The built zips by the tags of their Pythons, such as cp311."""
    paths = os.environ.get("SHAPEGOOGLE_EXTENSION")
    if not paths:
        pytest.skip("SHAPEGOOGLE_EXTENSION does not name built zips; run scripts/test.py tests/extension")
    return {path.stem.rpartition("-")[2]: path for path in map(Path, paths.split(os.pathsep))}


@pytest.fixture(scope="module")
def extension(host: Host, extensions: dict[str, Path]) -> Path:
    """The zip for the Python of a Blender."""
    return extensions[host.python_tag]
