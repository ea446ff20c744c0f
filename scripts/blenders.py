# SPDX-License-Identifier: MIT
"""The Blenders that the add-on is tested in: bpy modules, each in an environment of its own, and a real one.

Only the standard library is imported here, since this runs before anything is installed.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import environment
import wheels

__all__ = [
    "BLENDERS",
    "RealBlender",
    "find_real_blender",
    "folder",
    "prepare",
    "prepare_modules",
    "requirements",
]

OLDEST_BLENDER = (4, 2)
ENVIRONMENTS = environment.ROOT / ".venvs"
CACHE = environment.ROOT / ".cache"

# What `import bpy` and rendering without a window load; a render without libEGL would end the process.
SYSTEM_LIBRARIES = (
    *(
        "libx11-6",
        "libxrender1",
        "libxfixes3",
        "libxi6",
        "libxxf86vm1",
        "libxkbcommon0",
        "libsm6",
        "libgomp1",
    ),
    *("libgl1", "libgl1-mesa-dri", "libegl1", "libegl-mesa0"),
)
# 4.2 and 4.5 can crash while Python shuts down, hence _exit.
IMPORT_PROBE = """
import ctypes, os, sys
import bpy
if sys.platform == "linux":
    ctypes.CDLL("libEGL.so.1")
os._exit(0)
"""
REAL_PROBE = """
import importlib.util, json, sys, bpy
numpy = importlib.util.find_spec("numpy") is not None
print("\\nshape-google", json.dumps([bpy.app.version[:3], sys.version_info[:2], numpy]))
"""


@dataclass(frozen=True)
class Blender:
    """A Blender as a Python module, with the numpy and for the Python that this Blender ships."""

    bpy: str
    numpy: str
    python: str


BLENDERS = {
    "4.2": Blender("4.2.23", "1.24.3", "3.11"),
    "4.5": Blender("4.5.15", "1.26.4", "3.11"),
    "5.0": Blender("5.0.1", "1.26.4", "3.11"),
    "5.2": Blender("5.2.3", "2.3.4", "3.13"),
}


def prepare(series: str) -> Path:
    """Make or update the environment `.venvs/bpy-SERIES`, with the packages that the extension bundles.

    Parameters
    ----------
    series : str
        A key of `BLENDERS`, such as "4.5".

    Returns
    -------
    python : Path
        The environment's interpreter, which imports bpy and the core.

    Raises
    ------
    SetupError
        If this machine cannot have it; the message says why and what would help.
    """
    blender = BLENDERS[series]
    outer_python = find_python(blender.python)
    if outer_python is None:
        raise environment.SetupError(
            f"bpy {blender.bpy} needs Python {blender.python}, and none that runs was found"
        )
    wanted = [f"bpy=={blender.bpy}", f"numpy=={blender.numpy}"]
    wanted += [*requirements("extension"), *requirements("addon-test")]
    environment.prepare(environment.ROOT, folder(series), [], wanted, outer_python)
    python = environment.interpreter(folder(series))
    check_import(python, series)
    return python


def folder(series: str) -> Path:
    """Folder of the environment for one of `BLENDERS`."""
    return ENVIRONMENTS / f"bpy-{series}"


def find_python(version: str) -> str | None:
    """Return the path of a Python of this version that really runs; None if there is none.

    Looked for: the running Python, `pythonX.Y` on PATH, and those that pyenv keeps.
    """
    if environment.python_version() == version:
        return sys.executable
    candidates = [shutil.which(f"python{version}")]
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    candidates += sorted((str(path) for path in pyenv.glob(f"{version}.*/bin/python{version}")), reverse=True)
    return next((path for path in candidates if path and runs_as(path, version)), None)


def runs_as(python: str, version: str) -> bool:
    """Whether a Python runs and is of this version; pyenv has files on PATH that are not."""
    try:
        return environment.python_version(python) == version
    except environment.SetupError:
        return False


def requirements(group: str) -> list[str]:
    """Return one of the dependency groups in pyproject.toml."""
    import tomllib  # here, since an older Python must get as far as saying that it is too old

    with (environment.ROOT / "pyproject.toml").open("rb") as file:
        found: list[str] = tomllib.load(file)["dependency-groups"][group]
    return found


def check_import(python: Path, series: str) -> None:
    """Import bpy; install the system libraries it lacks if we may.

    Raises
    ------
    SetupError
        If bpy or libEGL cannot be loaded.
    """
    problem = import_problem(python)
    if problem and ".so" in problem and environment.install_system_packages(SYSTEM_LIBRARIES):
        problem = import_problem(python)
    if problem:
        raise environment.SetupError(
            f"bpy {BLENDERS[series].bpy} cannot be loaded ({problem}); "
            f"on Debian and Ubuntu its libraries come with: sudo apt install {' '.join(SYSTEM_LIBRARIES)}"
        )


def import_problem(python: Path) -> str:
    """Last line of what `import bpy` complains about; empty if it works."""
    result = subprocess.run(
        [str(python), "-c", IMPORT_PROBE], capture_output=True, text=True, errors="replace", check=False
    )
    if result.returncode == 0:
        return ""
    return (result.stderr.strip().splitlines() or [f"exit code {result.returncode}"])[-1]


@dataclass(frozen=True)
class RealBlender:
    """A Blender with a program of its own: its command, version, and the Python inside."""

    command: str
    version: str
    python: str
    has_numpy: bool


def find_real_blender() -> RealBlender:
    """Find the Blender named by the environment variable BLENDER, or else on PATH, and ask what it is.

    Returns
    -------
    blender : RealBlender

    Raises
    ------
    SetupError
        If there is none, it does not run, or it is too old.
    """
    named = os.environ.get("BLENDER")
    command = shutil.which(named or "blender")
    if command is None:
        where = f"BLENDER={named} is not a program" if named else "there is none on PATH or in BLENDER"
        raise environment.SetupError(where)
    command = os.path.abspath(command)  # noqa: PTH100 - a link to a launcher must not be followed
    try:
        result = subprocess.run(
            [command, "--background", "--factory-startup", "--python-expr", REAL_PROBE],
            cwd=environment.ROOT,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            timeout=900,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise environment.SetupError(f"{command} does not run: {error}") from error
    for line in result.stdout.splitlines():
        if line.startswith("shape-google "):
            version, python, has_numpy = json.loads(line.partition(" ")[2])
            return _supported(RealBlender(command, _dotted(version), _dotted(python), has_numpy))
    raise environment.SetupError(
        f"{command} does not say which Python it has:\n{result.stdout}{result.stderr}".rstrip()
    )


def _dotted(numbers: Iterable[int]) -> str:
    return ".".join(map(str, numbers))


def _supported(blender: RealBlender) -> RealBlender:
    if tuple(map(int, blender.version.split(".")[:2])) < OLDEST_BLENDER:
        raise environment.SetupError(
            f"{blender.command} is Blender {blender.version}, older than {_dotted(OLDEST_BLENDER)}"
        )
    return blender


def prepare_modules(blender: RealBlender) -> Path:
    """Install what the tests need inside a real Blender into a folder of its own.

    As `scripts/modules` in a folder that BLENDER_USER_RESOURCES names, Blender has it on its path by itself.

    Parameters
    ----------
    blender : RealBlender

    Returns
    -------
    modules : Path
        The packages the extension bundles, those of the tests, and numpy if that Blender has none.

    Raises
    ------
    SetupError
        If they cannot be installed.
    """
    modules = CACHE / f"blender-{blender.version}-python-{blender.python}"
    numpy = next((known.numpy for known in BLENDERS.values() if known.python == blender.python), None)
    if numpy is None:
        raise environment.SetupError(
            f"no numpy is known to fit the Python {blender.python} of {blender.command}"
        )
    wanted = [f"numpy=={numpy}", *requirements("extension"), *requirements("addon-test")]
    stamp = {"requirements": wanted, "has_numpy": blender.has_numpy}
    if environment.read_stamp(modules) == stamp:
        return modules
    shutil.rmtree(modules, ignore_errors=True)
    options = ["--target", str(modules), *wheels.pip_options(wheels.this_platform(), blender.python)]
    environment.run(
        f"Installing packages for Blender {blender.version} into {modules}",
        [sys.executable, "-m", "pip", "install", *environment.PIP_OPTIONS, *options, *wanted],
    )
    if blender.has_numpy:
        for part in modules.glob("numpy*"):
            shutil.rmtree(part)
    environment.write_stamp(modules, stamp)
    return modules
