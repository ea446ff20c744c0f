# SPDX-License-Identifier: MIT
"""Create the `.venv` of the repository on a fresh machine, and continue inside it.

Only the standard library is imported: this runs before anything is installed. Everything beyond the first
environment (Blender's bpy modules, checks, test runs) is a session of nox, see `noxfile.py`.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Collection, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

__all__ = [
    "ROOT",
    "VERSION_FILE",
    "SetupError",
    "enter",
    "install_system_packages",
    "nox",
    "prepare",
    "python_of",
    "read_stamp",
    "run",
    "write_stamp",
]

ROOT = Path(__file__).resolve().parents[2]
OLDEST_PYTHON = (3, 11)
STAMP = "shapegoogle-setup.json"
VERSION_FILE = Path("shapegoogle_core") / "__init__.py"


class SetupError(Exception):
    """The environment cannot be created; the message says why and what to do."""


def enter(extras: Collection[str]) -> None:
    """Continue inside the repository's `.venv`, which is created or updated first.

    The running script starts again under the interpreter of `.venv`, with the repository on its path. Call
    this before importing anything outside the standard library. Ends the process if the environment cannot be
    created.

    Parameters
    ----------
    extras : collection of str
        Optional dependencies of pyproject.toml to install.
    """
    folder = ROOT / ".venv"
    try:
        prepare(ROOT, folder, extras)
    except SetupError as error:
        sys.exit(f"Set-up failed: {error}")
    path = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    if Path(sys.prefix).resolve() == folder.resolve() and str(ROOT) in path:
        return
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, path)])
    command = [str(python_of(folder)), *sys.argv]
    sys.stdout.flush()
    if os.name == "nt":  # on Windows execv returns to the shell before the new process has ended
        sys.exit(subprocess.call(command))
    os.execv(command[0], command)


def prepare(root: Path, folder: Path, extras: Collection[str]) -> None:
    """Create or update a virtual environment with this package, its dependencies and nox.

    Nothing is installed, and no network is needed, if pyproject.toml, the version, the extras and Python are
    those of the last time.

    Parameters
    ----------
    root : Path
        Folder of pyproject.toml.
    folder : Path
        Of the virtual environment.
    extras : collection of str
        Optional dependencies to install. Those of an earlier call stay installed.

    Raises
    ------
    SetupError
        If Python is too old, or a step fails.
    """
    if sys.version_info < OLDEST_PYTHON:
        found, oldest = (".".join(map(str, numbers[:2])) for numbers in (sys.version_info, OLDEST_PYTHON))
        raise SetupError(
            f"Python {oldest} or newer is needed, but {sys.executable} is {found}; "
            f"run this script with a newer one, for example: python{oldest} {sys.argv[0]}"
        )
    stamp = read_stamp(folder)
    # What is installed also has the version, which the core states.
    stated = [path for path in (root / "pyproject.toml", root / VERSION_FILE) if path.exists()]
    wanted = {
        "extras": sorted({*extras, *stamp.get("extras", [])}),
        "pyproject": hashlib.sha256(b"".join(path.read_bytes() for path in stated)).hexdigest(),
        "python": [*sys.version_info[:2]],
        # Virtual environments and editable installations contain absolute paths.
        "root": str(root),
    }
    if stamp == wanted and python_of(folder).exists():
        return
    (folder / STAMP).unlink(missing_ok=True)
    if stamp.get("python") != wanted["python"] or not _has_pip(folder):
        _create(folder)
    target = f"{root}[{','.join(wanted['extras'])}]" if wanted["extras"] else str(root)
    pip = [str(python_of(folder)), "-m", "pip", "install", "--disable-pip-version-check"]
    run(f"Installing the package and its dependencies into {folder}", [*pip, "--editable", target, "nox"])
    write_stamp(folder, wanted)


def read_stamp(folder: Path) -> dict[str, Any]:
    """Read how a complete folder was made; empty if there is none, or it is not complete.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    stamp : dict
    """
    try:
        stamp = json.loads((folder / STAMP).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def write_stamp(folder: Path, stamp: Mapping[str, Any]) -> None:
    """Mark a folder as complete, with all that its content depends on.

    Parameters
    ----------
    folder : Path
    stamp : mapping
    """
    (folder / STAMP).write_text(json.dumps(stamp, indent=1) + "\n", encoding="utf-8")


def python_of(folder: Path) -> Path:
    """Path of the Python of a virtual environment.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    python : Path
    """
    return folder / "Scripts" / "python.exe" if os.name == "nt" else folder / "bin" / "python"


def nox(*arguments: str) -> list[str]:
    """Command line that runs nox on this repository.

    Parameters
    ----------
    *arguments : str
        Options of nox, such as ``--session``.

    Returns
    -------
    command : list of str
    """
    return [sys.executable, "-m", "nox", "--noxfile", str(ROOT / "noxfile.py"), *arguments]


def install_system_packages(packages: Sequence[str]) -> bool:
    """Install Debian packages if this process may.

    Parameters
    ----------
    packages : sequence of str

    Returns
    -------
    installed : bool
        False, without any attempt, if this is not root on Debian or a derivative.

    Raises
    ------
    SetupError
        If the installation fails.
    """
    if not hasattr(os, "geteuid") or os.geteuid() != 0 or not shutil.which("apt-get"):
        return False
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    run("Updating the list of Debian packages", ["apt-get", "update"], environment)
    command = ["apt-get", "install", "--yes", "--no-install-recommends", *packages]
    run(f"Installing the Debian packages {', '.join(packages)}", command, environment)
    return True


def run(title: str, command: Sequence[str], environment: Mapping[str, str] | None = None) -> None:
    """Run a command that prints only if it fails.

    Parameters
    ----------
    title : str
        Printed when the command starts.
    command : sequence of str
    environment : mapping, optional
        Environment variables instead of this process's.

    Raises
    ------
    SetupError
        If the command cannot be started, or ends with another exit code than 0; with all its output.
    """
    print(f"{title} ...", flush=True)
    try:
        result = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
            env=environment,
            check=False,
        )
    except OSError as error:
        raise SetupError(f"{title}: {command[0]} does not start ({error.strerror})") from error
    if result.returncode != 0:
        raise SetupError(
            f"{title}: exit code {result.returncode} of {' '.join(command)}\n\n{result.stdout.rstrip()}"
        )


def _has_pip(folder: Path) -> bool:
    python = python_of(folder)
    command = [str(python), "-m", "pip", "--version"]
    return python.exists() and subprocess.run(command, capture_output=True, check=False).returncode == 0


def _create(folder: Path) -> None:
    """Create an empty environment with pip, instead of an unusable one."""
    command = [sys.executable, "-m", "venv", "--clear", str(folder)]
    if find_spec("ensurepip") is None and find_spec("pip") is None:
        package = "python{}.{}-venv".format(*sys.version_info[:2])
        if not install_system_packages([package]):
            raise SetupError(
                f"{sys.executable} cannot create virtual environments, since its modules ensurepip and pip "
                f"are missing; on Debian and Ubuntu install them with: sudo apt install {package}"
            )
        run(f"Creating {folder}", command)
    elif find_spec("ensurepip") is None:
        # Debian without python3-venv: the pip beside this Python serves any environment.
        run(f"Creating {folder}", [*command, "--without-pip"])
        outer = [sys.executable, "-m", "pip", "--python", str(python_of(folder))]
        run("Installing pip", [*outer, "install", "--disable-pip-version-check", "pip"])
    else:
        run(f"Creating {folder}", command)
