# SPDX-License-Identifier: MIT
"""Set up, then run everything that must pass: lint, format, types and tests.

    python3 scripts/test.py [--fast | --long] [--all-blenders] [options of pytest, such as -k NAME, or a path]

The tests of the add-on run on the bpy modules of Blender 4.5 and 4.2, in a real Blender if the environment
variable BLENDER names one or there is one on PATH, and as installed from the built zip. What cannot run on
this machine is left out with a sentence. Options of pytest go to all runs, a path to the run it belongs to.

Exit code 0 if all passed. The last line counts the tests of all runs.

The tests in `tests/extension` and `tests/gui` find in the environment: SHAPEGOOGLE_EXTENSION, the built zip;
BLENDER, the real Blender; SHAPEGOOGLE_BLENDER_MODULES, a folder of Python packages for tests inside it (and
numpy, if it has none), meant to be the folder `scripts/modules` of what BLENDER_USER_RESOURCES names.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import blenders
import build_extension
import environment
import wheels

__all__ = ["main"]

CHECKS = {
    "ruff check": ["ruff", "check", "."],
    "ruff format": ["ruff", "format", "--check", "."],
    "mypy": ["mypy"],
}
EVERYDAY_BLENDERS = ("4.5", "4.2")
# One thread each: numerical libraries that thread themselves would fight over the cores.
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
ADDON_TESTS, EXTENSION_TESTS, WINDOW_TESTS = "tests/addon", "tests/extension", "tests/gui"
NO_TESTS_SELECTED = 5
# Options of pytest whose value is the next argument and might look like a path.
VALUED_OPTIONS = ("-k", "-m", "-p", "-n", "-c", "-o", "-W", "-r")
COUNT = re.compile(r"(\d+) (passed|failed|errors?|skipped|xfailed|xpassed)\b")
COUNTED_AS = {"error": "failed", "errors": "failed", "xfailed": "skipped", "xpassed": "passed"}


@dataclass(frozen=True)
class Run:
    """One run of pytest: its command line without the options common to all, and its environment."""

    name: str
    command: list[str]
    paths: list[str]
    variables: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What came of a run: exit code, and pytest's last line, such as `12 passed in 3.45s`."""

    code: int
    closing: str

    def counts(self) -> Counter[str]:
        """Count tests passed, failed and skipped; a run that broke off is at least one failed."""
        counts: Counter[str] = Counter()
        for number, what in COUNT.findall(self.closing):
            counts[COUNTED_AS.get(what, what)] += int(number)
        if self.code not in (0, NO_TESTS_SELECTED) and not counts["failed"]:
            counts["failed"] += 1
        return counts


def parse_arguments(arguments: Sequence[str] | None) -> tuple[argparse.Namespace, list[str]]:
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").split("\n")[0],
        epilog="All other options go to pytest.",
        allow_abbrev=False,
    )
    amount = parser.add_mutually_exclusive_group()
    amount.add_argument("--fast", action="store_true", help="leave out tests on real data")
    amount.add_argument("--long", action="store_true", help="run also the tests that take minutes")
    parser.add_argument(
        "--all-blenders",
        action="store_true",
        help=f"test the add-on on bpy {', '.join(blenders.BLENDERS)}, not {' and '.join(EVERYDAY_BLENDERS)}",
    )
    return parser.parse_known_args(arguments)


def marker_expression(options: argparse.Namespace) -> str:
    """Which tests to run, as pytest's option -m says it."""
    if options.long:
        return ""
    return "not long and not real_data" if options.fast else "not long"


def data_folder() -> Path:
    """Where the tests look for the evaluation meshes."""
    return Path(os.environ.get("SHAPEGOOGLE_DATA") or environment.ROOT.parent / "shared" / "data")


def split_paths(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split arguments for pytest into paths of tests and all others."""
    paths: list[str] = []
    others: list[str] = []
    before = ""
    for argument in arguments:
        is_path = (
            not argument.startswith("-")
            and before not in VALUED_OPTIONS
            and (environment.ROOT / argument.partition("::")[0]).exists()
        )
        (paths if is_path else others).append(argument)
        before = argument
    return paths, others


def paths_for(folder: str, paths: Sequence[str]) -> list[str]:
    """Choose what a run of the tests in one folder is to look at; nothing if that run is not wanted.

    Parameters
    ----------
    folder : str
        Relative to the repository.
    paths : sequence of str
        Given by the user; none: everything.
    """
    whole = environment.ROOT / folder
    if not whole.is_dir():
        return []
    if not paths:
        return [folder]
    places = {path: (environment.ROOT / path.partition("::")[0]).resolve() for path in paths}
    if any(whole.is_relative_to(place) for place in places.values()):
        return [folder]
    return [path for path, place in places.items() if place.is_relative_to(whole)]


def paths_for_core(paths: Sequence[str]) -> list[str] | None:
    """Likewise, for tests that need no Blender; empty: those pyproject.toml names; None: not wanted."""
    if not paths:
        return []
    elsewhere = [environment.ROOT / folder for folder in (ADDON_TESTS, EXTENSION_TESTS, WINDOW_TESTS)]
    found = []
    for path in paths:
        place = (environment.ROOT / path.partition("::")[0]).resolve()
        if place in (environment.ROOT, environment.ROOT / "tests"):
            return []
        if not any(place.is_relative_to(folder) for folder in elsewhere):
            found.append(path)
    return found or None


def run_check(name: str, command: Sequence[str]) -> bool:
    """Run one check; its output is shown if it fails."""
    result = subprocess.run(
        [sys.executable, "-m", *command],
        cwd=environment.ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    passed = result.returncode == 0
    print(f"{name}: {'passed' if passed else 'FAILED'}", flush=True)
    if not passed:
        print(result.stdout.rstrip(), flush=True)
    return passed


def run_tests(run: Run, options: Sequence[str], live: bool) -> Outcome:
    """Run pytest, show what it prints, and its last line with the name of the run.

    Parameters
    ----------
    run : Run
    options : sequence of str
        For pytest.
    live : bool
        Show every line at once, not all when it is done.
    """
    process = subprocess.Popen(
        [*run.command, "--quiet", *options, *run.paths],
        cwd=environment.ROOT,
        env={**os.environ, **ENVIRONMENT, **run.variables},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        errors="replace",
    )
    held_back: list[str] = []
    with process:
        for line in process.stdout or ():
            held_back.append(line)
            if live:
                print("".join(held_back[:-1]), end="", flush=True)
                del held_back[:-1]
    closing = held_back.pop().strip() if held_back else ""
    outcome = Outcome(process.returncode, closing)
    if not COUNT.search(closing) and process.returncode not in (0, NO_TESTS_SELECTED):
        closing = f"{closing}\n{run.name}: BROKE OFF, exit code {process.returncode}"
    print("".join([*held_back, f"{run.name}: {closing}"]), flush=True)
    return outcome


class Plan:
    """The runs that this machine can do, and sentences about the others."""

    def __init__(self, paths: Sequence[str]) -> None:
        self.paths = paths
        self.core: list[Run] = []
        self.addon: list[Run] = []
        self.window: list[Run] = []
        self.left_out: list[str] = []
        self.broken: list[str] = []

    def add_core(self) -> None:
        """Add the tests that need no Blender, two at a time."""
        paths = paths_for_core(self.paths)
        if paths is not None:
            command = [sys.executable, "-m", "pytest", "--numprocesses=2"]
            self.core.append(Run("core", command, paths))

    def add_bpy(self, series: Iterable[str]) -> None:
        """Add the add-on's tests on bpy modules."""
        paths = paths_for(ADDON_TESTS, self.paths)
        for name in series if paths else ():
            try:
                python = blenders.prepare(name)
            except environment.SetupError as error:
                self.left_out.append(f"the add-on's tests on bpy {name}: {error}")
                continue
            self.addon.append(Run(f"add-on on bpy {name}", [str(python), "tests/run_in_blender.py"], paths))

    def add_real_blender(self, user_folder: Path) -> None:
        """Add those inside a real Blender, those of its window, and those of the built zip."""
        addon, extension, window = (
            paths_for(folder, self.paths) for folder in (ADDON_TESTS, EXTENSION_TESTS, WINDOW_TESTS)
        )
        if not addon and not extension and not window:
            return
        variables: dict[str, str] = {}
        package = self.build()
        try:
            real = blenders.find_real_blender()
            modules = blenders.prepare_modules(real)
            if addon and package:
                self._add_addon_inside(real, modules, package, user_folder, addon)
        except environment.SetupError as error:
            self.left_out.append(f"all tests in a real Blender: {error}")
        else:
            variables |= {"BLENDER": real.command, "SHAPEGOOGLE_BLENDER_MODULES": str(modules)}
        if package:
            self.add_extension(extension, window, {**variables, "SHAPEGOOGLE_EXTENSION": str(package)})

    def _add_addon_inside(
        self, real: blenders.RealBlender, modules: Path, package: Path, user_folder: Path, paths: list[str]
    ) -> None:
        """Add the add-on's tests inside a real Blender, where the add-on is the installed extension."""
        (user_folder / "scripts").mkdir()
        (user_folder / "scripts" / "modules").symlink_to(modules, target_is_directory=True)
        resources = {"BLENDER_USER_RESOURCES": str(user_folder)}
        install = ["extension", "install-file", "--repo", "user_default", "--enable", str(package)]
        environment.run(
            f"Installing the extension in Blender {real.version}",
            [real.command, "--command", *install],
            {**os.environ, **resources},
        )
        command = [real.command, "--background", "--python-exit-code", "1"]
        command += ["--python", "tests/run_in_blender.py", "--"]
        self.addon.append(Run(f"add-on in Blender {real.version}", command, paths, resources))

    def build(self) -> Path | None:
        """Build the extension; None if it cannot be built here."""
        try:
            build_extension.extension_tool()
        except environment.SetupError as error:
            self.left_out.append(f"the tests of the built extension: {error}")
            return None
        try:
            return build_extension.build(wheels.this_platform())
        except environment.SetupError as error:
            print(f"The extension cannot be built: {error}", flush=True)
            self.broken.append("building the extension")
            return None

    def add_extension(self, extension: list[str], window: list[str], variables: dict[str, str]) -> None:
        """Add the tests of the built zip, without and with a window."""
        pytest = [sys.executable, "-m", "pytest"]
        if extension:
            self.addon.append(Run("extension", pytest, extension, variables))
        if window and "BLENDER" in variables:
            if shutil.which("Xvfb"):
                self.window.append(Run("window", pytest, window, variables))
            else:
                self.left_out.append("the window tests: they need Xvfb (Debian: sudo apt install xvfb)")


def run_all(plan: Plan, options: Sequence[str]) -> dict[str, Outcome]:
    """Run the core's tests, then those of the add-on two at a time, then those that watch the clock alone."""
    colour = ["--color=yes"] if sys.stdout.isatty() else []
    outcomes = {run.name: run_tests(run, [*colour, *options], live=True) for run in plan.core}
    with ThreadPoolExecutor(2) as pool:
        results = pool.map(lambda run: run_tests(run, [*colour, *options], live=False), plan.addon)
        outcomes |= dict(zip((run.name for run in plan.addon), results, strict=True))
    return outcomes | {run.name: run_tests(run, [*colour, *options], live=True) for run in plan.window}


def main(arguments: Sequence[str] | None = None) -> int:
    options, passed_on = parse_arguments(arguments)
    environment.enter(["benchmark", "demo", "test"])
    started = time.monotonic()
    checks = {name: run_check(name, command) for name, command in CHECKS.items()}
    folder = data_folder()
    state = "left out" if options.fast else f"use {folder}" if folder.is_dir() else f"skipped, no {folder}"
    print(f"tests on real data: {state}", flush=True)

    paths, others = split_paths(passed_on)
    plan = Plan(paths)
    with tempfile.TemporaryDirectory(prefix="shape-google-blender-") as user_folder:
        plan.add_core()
        plan.add_bpy(blenders.BLENDERS if options.all_blenders else EVERYDAY_BLENDERS)
        plan.add_real_blender(Path(user_folder))
        outcomes = run_all(plan, ["-m", marker_expression(options), *others])

    passed_codes = {0, NO_TESTS_SELECTED} if any(outcome.code == 0 for outcome in outcomes.values()) else {0}
    results = {**checks, **{name: outcome.code in passed_codes for name, outcome in outcomes.items()}}
    failed = [*plan.broken, *(name for name, passed in results.items() if not passed)]
    for sentence in plan.left_out:
        print(f"LEFT OUT: {sentence}")
    print(f"FAILED: {', '.join(failed)}" if failed else f"All passed: {', '.join(results)}")
    total: Counter[str] = sum((outcome.counts() for outcome in outcomes.values()), Counter())
    print(f"in {time.monotonic() - started:.0f} s:")
    print(", ".join(f"{total[what]} {what}" for what in ("passed", "failed", "skipped")), flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
