# SPDX-License-Identifier: MIT
"""The `.venv` that the commands beside this file set up for themselves and run in.

Environments with Blender's bpy module are made by the same functions, from `blenders.py`. Only the standard
library is imported here, since this runs before anything is installed.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Any, NoReturn

__all__ = ["ROOT", "SetupError", "enter", "install_system_packages", "interpreter", "prepare", "run", "tool"]

ROOT = Path(__file__).resolve().parent.parent
OLDEST_PYTHON = (3, 11)
STAMP_NAME = "shapegoogle-setup.json"
PIP_OPTIONS = ["--no-user", "--no-input", "--disable-pip-version-check", "--progress-bar=off"]


class SetupError(Exception):
    """The environment cannot be made; the message says why and what to do."""


def enter(extras: Collection[str]) -> None:
    """Go on inside the repository's `.venv`, which is made or brought up to date first.

    The running script starts again under the interpreter of `.venv` unless it already runs there, so call
    this before anything that is not in the standard library is imported. Ends the process when the
    environment cannot be made.

    Parameters
    ----------
    extras : collection of str
        Optional dependencies of pyproject.toml to install too.
    """
    folder = ROOT / ".venv"
    try:
        prepare(ROOT, folder, extras)
    except SetupError as error:
        sys.exit(f"Set-up failed: {error}")
    if Path(sys.prefix).resolve() != folder.resolve():
        restart(interpreter(folder))


def prepare(
    root: Path,
    folder: Path,
    extras: Collection[str],
    requirements: Collection[str] = (),
    python: str = sys.executable,
) -> None:
    """Make or update a virtual environment with this package in it, if it is not as wanted yet.

    Nothing is installed, and no network is needed, when neither pyproject.toml nor the requirements nor
    Python changed since last time.

    Parameters
    ----------
    root : Path
        Folder of pyproject.toml.
    folder : Path
        Of the virtual environment.
    extras : collection of str
        Optional dependencies to install too. What an earlier call installed stays.
    requirements : collection of str
        Other packages to install, as pip takes them, such as `numpy==1.24.3`.
    python : str
        The Python to make the environment with; the running one when left out.

    Raises
    ------
    SetupError
        If Python is too old, or a step fails.
    """
    check_python(sys.version_info[:2])
    version = python_version(python)
    stamp = read_stamp(folder)
    wanted = wanted_stamp(root, sorted({*extras, *stamp.get("extras", [])}), requirements, version)
    if stamp == wanted and interpreter(folder).exists():
        return
    (folder / STAMP_NAME).unlink(missing_ok=True)
    if not is_usable(folder, version):
        create(folder, python)
    install(root, folder, wanted["extras"], requirements)
    write_stamp(folder, wanted)


def tool(name: str) -> Path:
    """Path of a command that is installed in the environment this script runs in."""
    return Path(sys.executable).with_name(name + (".exe" if os.name == "nt" else ""))


def interpreter(folder: Path) -> Path:
    """Path of the Python of a virtual environment."""
    return folder / "Scripts" / "python.exe" if os.name == "nt" else folder / "bin" / "python"


def restart(python: Path) -> NoReturn:
    """Run this script again, with the same arguments, under another Python."""
    command = [str(python), *sys.argv]
    sys.stdout.flush()
    if os.name == "nt":  # there, execv returns to the shell before the new process is done
        sys.exit(subprocess.call(command))
    os.execv(command[0], command)


def check_python(version: tuple[int, ...]) -> None:
    """Refuse a Python that is too old for the package."""
    if version < OLDEST_PYTHON:
        found, oldest = (".".join(map(str, numbers)) for numbers in (version, OLDEST_PYTHON))
        raise SetupError(
            f"Python {oldest} or newer is needed, but {sys.executable} is {found}; "
            f"run this script with a newer one, for example: python{oldest} {sys.argv[0]}"
        )


def wanted_stamp(
    root: Path, extras: list[str], requirements: Collection[str] = (), version: str | None = None
) -> dict[str, Any]:
    """Describe a complete environment by all that its installation depends on.

    Virtual environments and editable installations contain absolute paths, so a moved repository counts
    as changed.
    """
    return {
        "extras": extras,
        "pyproject": hashlib.sha256((root / "pyproject.toml").read_bytes()).hexdigest(),
        "python": version or python_version(),
        "requirements": sorted(requirements),
        "root": str(root),
    }


def read_stamp(folder: Path) -> dict[str, Any]:
    """Return what an earlier set-up left; empty if there was none or it did not finish."""
    try:
        stamp = json.loads((folder / STAMP_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def write_stamp(folder: Path, stamp: dict[str, Any]) -> None:
    """Leave word that a folder is complete, and of what that depends on."""
    (folder / STAMP_NAME).write_text(json.dumps(stamp, indent=1) + "\n", encoding="utf-8")


def python_version(python: str = sys.executable) -> str:
    """Return the version of a Python, such as `3.11`, as far as installed packages depend on it."""
    if python == sys.executable:
        return "{}.{}".format(*sys.version_info[:2])
    command = [python, "-c", "import sys; print('{}.{}'.format(*sys.version_info[:2]))"]
    try:
        result = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise SetupError(f"{python} does not run: {error}") from error
    return result.stdout.strip()


def environment_version(folder: Path) -> str | None:
    """Return the Python version a virtual environment was made for; None if it is not one."""
    try:
        lines = (folder / "pyvenv.cfg").read_text(encoding="utf-8").splitlines()
    except OSError:
        return None
    for line in lines:
        key, _, value = line.partition("=")
        if key.strip() in ("version", "version_info"):
            return ".".join(value.strip().split(".")[:2])
    return None


def is_usable(folder: Path, version: str | None = None) -> bool:
    """Whether an environment is of the wanted Python, or else the running one, and has a pip that runs."""
    if environment_version(folder) != (version or python_version()) or not interpreter(folder).exists():
        return False
    return subprocess.run([*pip(folder), "--version"], capture_output=True, check=False).returncode == 0


def has_module(name: str, python: str = sys.executable) -> bool:
    """Whether a Python has a module."""
    if python == sys.executable:
        return importlib.util.find_spec(name) is not None
    command = [python, "-c", f"import {name}"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def pip(folder: Path) -> list[str]:
    """Return the start of a command line that runs the pip of an environment."""
    return [str(interpreter(folder)), "-m", "pip"]


def create(folder: Path, python: str = sys.executable) -> None:
    """Make an environment that has only pip, or put pip into one; one whose Python is gone is replaced."""
    if not has_module("ensurepip", python) and not has_module("pip", python):
        install_venv_module(python)
    command = [python, "-m", "venv", str(folder)]
    if environment_version(folder) != python_version(python) or not interpreter(folder).exists():
        command.append("--clear")
    if has_module("ensurepip", python):
        run(f"Making {folder}", command)
    else:
        # Debian without the package python3-venv; a pip beside that Python serves any environment.
        run(f"Making {folder}", [*command, "--without-pip"])
        outer_pip = [python, "-m", "pip", "--python", str(interpreter(folder))]
        run("Installing pip", [*outer_pip, "install", *PIP_OPTIONS, "pip"])


def install_venv_module(python: str = sys.executable) -> None:
    """Install what Debian leaves out of Python's venv module, if we may."""
    package = f"python{python_version(python)}-venv"
    if not install_system_packages([package]):
        raise SetupError(
            f"{python} cannot make virtual environments, since its modules ensurepip and pip are "
            f"missing; on Debian and Ubuntu install them with: sudo apt install {package}"
        )
    importlib.invalidate_caches()
    if not has_module("ensurepip", python):
        raise SetupError(f"{package} is installed, but {python} does not find its module ensurepip")


def install_system_packages(packages: Sequence[str]) -> bool:
    """Install Debian packages, if we may.

    Parameters
    ----------
    packages : sequence of str

    Returns
    -------
    installed : bool
        False, and nothing was tried, if this is not root on Debian or its like.

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


def install(root: Path, folder: Path, extras: Iterable[str], requirements: Iterable[str] = ()) -> None:
    """Install the package at `root`, editable, with its dependencies, and other packages."""
    names = ",".join(extras)
    target = f"{root}[{names}]" if names else str(root)
    run(
        f"Installing the package and its dependencies ({names or 'no extras'}) into {folder}",
        [*pip(folder), "install", *PIP_OPTIONS, "--editable", target, *requirements],
    )


def run(title: str, command: Sequence[str], environment: dict[str, str] | None = None) -> None:
    """Run a command that only speaks when it fails.

    On a terminal, the last line of its output is shown while it runs.

    Parameters
    ----------
    title : str
        What is being done.
    command : sequence of str
    environment : dict, optional
        Environment variables in place of this process's.

    Raises
    ------
    SetupError
        If it cannot start or returns anything but 0, with all its output.
    """
    print(f"{title} ...", flush=True)
    started = time.monotonic()
    live = sys.stdout.isatty()
    width = shutil.get_terminal_size().columns - 1
    output = []
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
            env=environment,
        )
    except OSError as error:
        raise SetupError(f"{title}: {command[0]} does not start ({error})") from error
    with process:
        for line in process.stdout or ():
            output.append(line)
            if live:
                print(f"\r{('  ' + line.strip())[:width]:<{width}}", end="", flush=True)
    if live:
        print(f"\r{'':<{width}}\r", end="")
    if process.returncode != 0:
        shown = " ".join(command)
        raise SetupError(f"{title}: exit code {process.returncode} of {shown}\n\n{''.join(output).rstrip()}")
    print(f"  done in {time.monotonic() - started:.0f} s", flush=True)
