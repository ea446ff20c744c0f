# SPDX-License-Identifier: MIT
"""Sessions of checks and tests; `python3 scripts/test.py` runs them all.

    python -m nox --session core -- -k heat        (in the `.venv` that the scripts create)

`checks` and `core` run in the environment that nox runs in. The add-on is tested on Blender's bpy modules
(`addon-…`, an environment each), inside a real Blender (`blender`), as installed from the built zip
(`extension`), and in a real window (`window`). The environment variable BLENDER names the real Blender;
without it, one on PATH is used. Sessions that cannot run on a machine are skipped with the reason.

Tests in `tests/extension` and `tests/gui` find in the environment: SHAPEGOOGLE_EXTENSION, the built zip
(`tests/extension`: one for each Python, separated as in PATH); BLENDER; SHAPEGOOGLE_BLENDER_MODULES, a folder
of Python packages for tests inside that Blender.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import nox
from filelock import BaseFileLock, FileLock  # comes with nox
from nox.command import CommandFailed

ROOT = Path(__file__).resolve().parent
PROJECT = nox.project.load_toml(ROOT / "pyproject.toml")
BLENDERS: dict[str, dict[str, str]] = PROJECT["tool"]["shapegoogle"]["blenders"]
OLDEST_BLENDER = (4, 2)
MODULES = ROOT / ".cache" / "blender-modules"
# One thread each: numerical libraries with threads of their own would compete for the cores.
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
# Tests start hundreds of processes. Imports and collecting tests take much less time if what Python has
# compiled is kept, also where the user's environment says not to.
ENVIRONMENT["PYTHONDONTWRITEBYTECODE"] = ""

# Loaded by `import bpy` and by rendering without a window; rendering without libEGL ends the process.
SYSTEM_LIBRARIES = (
    *("libx11-6", "libxrender1", "libxfixes3", "libxi6", "libxxf86vm1", "libxkbcommon0", "libsm6"),
    *("libgomp1", "libgl1", "libgl1-mesa-dri", "libegl1", "libegl-mesa0"),
)
# The bpy modules of 4.2 and 4.5 can crash while Python shuts down, hence _exit.
BPY_PROBE = """
import ctypes, os, sys
try:
    import bpy
    if sys.platform == "linux":
        ctypes.CDLL("libEGL.so.1")
except (ImportError, OSError) as error:
    print(error, file=sys.stderr, flush=True)
    os._exit(1)
os._exit(0)
"""
BLENDER_PROBE = """
import importlib.util, json, sys, bpy
numpy = importlib.util.find_spec("numpy") is not None
print("\\nshape-google", json.dumps([bpy.app.version[:3], sys.version_info[:2], numpy]))
"""

# Three processes for two processors, since some tests wait for others to end. Each file's tests stay in one
# process, which makes what they share once.
SPREAD = ("--numprocesses=3", "--dist=loadfile")

nox.options.default_venv_backend = "venv"
nox.options.reuse_existing_virtualenvs = True
nox.options.stop_on_first_error = False


@nox.session(python=False)
def checks(session: nox.Session) -> None:
    """Check lint, format and types."""
    python = [sys.executable, "-m"]
    session.run(*python, "ruff", "check", ".", external=True)
    session.run(*python, "ruff", "format", "--check", ".", external=True)
    session.run(*python, "mypy", external=True)


@nox.session(python=False)
def core(session: nox.Session) -> None:
    """Test what needs no Blender, in several processes."""
    install_for_tests(session)
    # Sessions that work in one process go first: this one uses what they leave.
    if hasattr(os, "nice"):
        os.nice(5)
    command = [sys.executable, "-m", "pytest", "--quiet", *SPREAD, *session.posargs]
    session.run(*command, env=ENVIRONMENT, external=True)


@nox.session(python=False)
def coverage(session: nox.Session) -> None:
    """Say which share of the core's lines its tests run; the pages go to .cache/coverage/html."""
    reports = ["--cov", "--cov-report=html", "--cov-report=term:skip-covered"]
    command = [sys.executable, "-m", "pytest", *SPREAD, *reports]
    session.run(*command, *pytest_options(session.posargs, "tests/core"), env=ENVIRONMENT, external=True)


def add_bpy_session(series: str, python: str) -> None:
    """Add the session that tests the add-on on the bpy module of one Blender.

    Parameters
    ----------
    series : str
        A key of `BLENDERS`, such as "4.5".
    python : str
        Version of the Python that this Blender ships.
    """

    @nox.session(name=f"addon-{series}", python=find_python(python) or python)
    def addon(session: nox.Session) -> None:
        versions = BLENDERS[series]
        pins = [f"bpy=={versions['bpy']}", f"numpy=={versions['numpy']}"]
        session.install("--only-binary=:all:", *pins, *requirements("extension"), *requirements("addon-test"))
        load_bpy(session)
        run_in_module(session, "tests/run_in_blender.py", *pytest_options(session.posargs, "tests/addon"))

    addon.__doc__ = f"Test the add-on on the bpy module of Blender {series}."


def run_in_module(session: nox.Session, *arguments: str) -> None:
    """Run a script with Python and a bpy module, and once more if the module itself has crashed.

    The one of 4.2 crashed while it opened a file, once in about a hundred runs of the tests, with only its
    own code on the stack. A fault of the add-on would crash it again.

    Parameters
    ----------
    session : nox.Session
        With the module in its environment.
    *arguments : str
        Script and its arguments.
    """
    try:
        session.run("python", *arguments, env=ENVIRONMENT)
    except CommandFailed as error:
        # Whatever a signal has ended has a negative code; failed tests have a positive one.
        if error.return_code is None or error.return_code >= 0:
            raise
        session.warn(f"The bpy module crashed (code {error.return_code}); all of its tests run once more.")
        session.run("python", *arguments, env=ENVIRONMENT)


@nox.session(python=False)
def docs(session: nox.Session) -> None:
    """Build the documentation site, running every example."""
    session.run(sys.executable, "scripts/build_docs.py", external=True)


@nox.session(python=False)
def build(session: nox.Session) -> None:
    """Build the zips of the extension for this machine."""
    session.run(sys.executable, "scripts/build_extension.py", external=True)


@nox.session(python=False)
def blender(session: nox.Session) -> None:
    """Test the add-on inside a real Blender, as the installed extension."""
    real = real_blender_or_skip(session)
    modules = install_modules(session, real)
    with tempfile.TemporaryDirectory(prefix="shape-google-blender-") as folder:
        # Blender has `scripts/modules` of its user folder on its path.
        Path(folder, "scripts").mkdir()
        Path(folder, "scripts", "modules").symlink_to(modules, target_is_directory=True)
        environment = {**ENVIRONMENT, "BLENDER_USER_RESOURCES": folder}
        install = [
            "extension",
            "install-file",
            "--repo",
            "user_default",
            "--enable",
            built_zip(session, real.python),
        ]
        session.run(real.command, "--command", *install, env=environment, external=True, silent=True)
        command = [real.command, "--background", "--python-exit-code", "1"]
        command += [
            "--python",
            "tests/run_in_blender.py",
            "--",
            *pytest_options(session.posargs, "tests/addon"),
        ]
        session.run(*command, env=environment, external=True)


@nox.session(python=False)
def extension(session: nox.Session) -> None:
    """Test the built zips; the tests that need a real Blender are skipped without one."""
    pythons = sorted({known["python"] for known in BLENDERS.values()})
    zips = [built_zip(session, python) for python in pythons]
    environment = {**ENVIRONMENT, "SHAPEGOOGLE_EXTENSION": os.pathsep.join(zips)}
    try:
        environment |= variables_of(session, find_real_blender())
    except BlenderMissingError as error:
        session.warn(f"no real Blender: {error}")
    command = [sys.executable, "-m", "pytest", *pytest_options(session.posargs, "tests/extension")]
    session.run(*command, env=environment, external=True)


@nox.session(python=False)
def window(session: nox.Session) -> None:
    """Test in the window of a real Blender, on a virtual screen."""
    if not shutil.which("Xvfb"):
        session.skip("the window tests need Xvfb (Debian: sudo apt install xvfb xdotool imagemagick)")
    real = real_blender_or_skip(session)
    zip_file = {"SHAPEGOOGLE_EXTENSION": built_zip(session, real.python)}
    command = [sys.executable, "-m", "pytest", *pytest_options(session.posargs, "tests/gui")]
    session.run(*command, env=ENVIRONMENT | zip_file | variables_of(session, real), external=True)


# -- helpers ------------------------------------------------------------------------------------------------


class BlenderMissingError(Exception):
    """There is no real Blender that can be used; the message says why."""


@dataclass(frozen=True)
class RealBlender:
    """A Blender that is a program: its command, version, and the Python inside."""

    command: str
    version: str
    python: str
    has_numpy: bool


def pytest_options(given: Sequence[str], folder: str) -> list[str]:
    """List the options of pytest for a session: those given, and its folder unless tests are named."""
    named = any(option.startswith("tests/") for option in given)
    return ["--quiet", *given, *([] if named else [folder])]


def requirements(group: str) -> list[str]:
    """List the packages of a dependency group of pyproject.toml."""
    return list(nox.project.dependency_groups(PROJECT, group))


def find_python(version: str) -> str | None:
    """Path of a Python of this version that runs; pyenv has files on PATH that do not."""
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    candidates = [sys.executable, shutil.which(f"python{version}")]
    candidates += sorted(map(str, pyenv.glob(f"{version}.*/bin/python{version}")), reverse=True)
    probe = "import sys; print('{}.{}'.format(*sys.version_info[:2]))"
    for candidate in filter(None, candidates):
        result = subprocess.run([candidate, "-c", probe], capture_output=True, text=True, check=False)
        if result.stdout.strip() == version:
            return candidate
    return None


def load_bpy(session: nox.Session) -> None:
    """Import bpy; install the system libraries that it lacks if this process may."""
    probe = partial(session.run, "python", "-c", BPY_PROBE, silent=True, success_codes=[0, 1])
    problem = probe()
    if problem and can_use_apt():
        apt_install(session, *SYSTEM_LIBRARIES)
        problem = probe()
    if problem:
        session.skip(
            f"bpy cannot be loaded ({str(problem).strip()}); on Debian and Ubuntu its libraries come with: "
            f"sudo apt install {' '.join(SYSTEM_LIBRARIES)}"
        )


def install_for_tests(session: nox.Session) -> None:
    """Install PostgreSQL and a browser if this process may; without them a package serves, or tests skip."""
    wanted = {
        "postgresql": any(Path("/usr/lib/postgresql").glob("*/bin/postgres")),
        "chromium": shutil.which("chromium") is not None,
    }
    missing = [package for package, there in wanted.items() if not there]
    if not missing or not can_use_apt():
        return
    for package in missing:  # without a network the tests have to do without
        apt_install(session, package, success_codes=[*range(128)])


def apt_install(session: nox.Session, *packages: str, success_codes: Sequence[int] = (0,)) -> None:
    """Install Debian packages."""
    with lock("apt"):
        for command in (["update"], ["install", "--yes", "--no-install-recommends", *packages]):
            session.run(
                "apt-get",
                *command,
                external=True,
                silent=True,
                success_codes=success_codes,
                env={"DEBIAN_FRONTEND": "noninteractive"},
            )


def lock(name: str) -> BaseFileLock:
    """Return the lock of what only one of the sessions that run at once may do at a time."""
    folder = ROOT / ".cache"
    folder.mkdir(exist_ok=True)
    return FileLock(folder / f"{name}.lock")


def can_use_apt() -> bool:
    """Whether this process may install Debian packages."""
    return hasattr(os, "geteuid") and os.geteuid() == 0 and shutil.which("apt-get") is not None


def find_real_blender() -> RealBlender:
    """Find the Blender named by BLENDER, or else on PATH, and ask for its versions."""
    named = os.environ.get("BLENDER")
    command = shutil.which(named or "blender")
    if command is None:
        raise BlenderMissingError(
            f"BLENDER={named} is not a program" if named else "there is none on PATH or in BLENDER"
        )
    command = os.path.abspath(command)  # noqa: PTH100 - a link to a launcher must not be followed
    probe = [command, "--background", "--factory-startup", "--python-expr", BLENDER_PROBE]
    try:
        # A launcher may install what it needs when it runs for the first time, which two must not do at once.
        with lock("blender"):
            result = subprocess.run(probe, capture_output=True, text=True, errors="replace", check=False)
    except OSError as error:
        raise BlenderMissingError(f"{command} does not run: {error}") from error
    for line in result.stdout.splitlines():
        if line.startswith("shape-google "):
            version, python, has_numpy = json.loads(line.partition(" ")[2])
            if tuple(version[:2]) < OLDEST_BLENDER:
                raise BlenderMissingError(f"{command} is Blender {dotted(version)}, older than 4.2")
            return RealBlender(command, dotted(version), dotted(python), has_numpy)
    raise BlenderMissingError(f"{command} does not report its Python:\n{result.stdout}{result.stderr}")


def dotted(numbers: list[int]) -> str:
    """Write version numbers with dots."""
    return ".".join(map(str, numbers))


def real_blender_or_skip(session: nox.Session) -> RealBlender:
    """Find a real Blender; skip the session without one."""
    try:
        return find_real_blender()
    except BlenderMissingError as error:
        session.skip(f"no real Blender: {error}")


def install_modules(session: nox.Session, real: RealBlender) -> Path:
    """Install the packages of the extension and its tests for a real Blender, into their own folder."""
    numpy = next((known["numpy"] for known in BLENDERS.values() if known["python"] == real.python), None)
    if numpy is None:
        session.skip(f"no numpy is known to fit the Python {real.python} of {real.command}")
    wanted = [
        *requirements("extension"),
        *requirements("addon-test"),
        *([] if real.has_numpy else [f"numpy=={numpy}"]),
    ]
    folder = MODULES / f"blender-{real.version}-python-{real.python}"
    stamp = folder / "requirements.txt"
    with lock("blender-modules"):
        if stamp.exists() and stamp.read_text(encoding="utf-8").split("\n") == wanted:
            return folder
        shutil.rmtree(folder, ignore_errors=True)
        options = ["--only-binary=:all:", f"--python-version={real.python}", "--target", str(folder)]
        session.run(
            sys.executable,
            "-m",
            "pip",
            "install",
            "--quiet",
            *options,
            *wanted,
            f"numpy=={numpy}",
            external=True,
        )
        if real.has_numpy:
            for part in folder.glob("numpy*"):
                shutil.rmtree(part)
        stamp.write_text("\n".join(wanted), encoding="utf-8")
    return folder


def variables_of(session: nox.Session, real: RealBlender) -> dict[str, str]:
    """Environment variables by which tests find a real Blender and their packages inside it."""
    return {"BLENDER": real.command, "SHAPEGOOGLE_BLENDER_MODULES": str(install_modules(session, real))}


def built_zip(session: nox.Session, python: str) -> str:
    """Path of the extension for this machine and a Python, built if its sources have changed."""
    command = [sys.executable, "scripts/build_extension.py", "--python", python]
    output = session.run(*command, external=True, silent=True)
    # The last line: the path, then size and time.
    return str(ROOT / str(output).strip().splitlines()[-1].partition(":")[0])


for _series, _versions in BLENDERS.items():
    add_bpy_session(_series, _versions["python"])
