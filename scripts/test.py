# SPDX-License-Identifier: MIT
"""Set up, then run everything that must pass: lint, format, types and tests.

    python3 scripts/test.py [--fast | --long] [any option of pytest, such as -k NAME or a path]

Exit code 0 if all passed. The last line is pytest's own.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import environment

__all__ = ["main"]

CHECKS = {
    "ruff check": ["ruff", "check", "."],
    "ruff format": ["ruff", "format", "--check", "."],
    "mypy": ["mypy"],
}
# Two workers with one thread each: numerical libraries that thread themselves would fight over the cores.
TEST_OPTIONS = ["--quiet", "--numprocesses=2"]
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def parse_arguments(arguments: Sequence[str] | None) -> tuple[argparse.Namespace, list[str]]:
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").split("\n")[0],
        epilog="All other options go to pytest.",
        allow_abbrev=False,
    )
    amount = parser.add_mutually_exclusive_group()
    amount.add_argument("--fast", action="store_true", help="leave out tests on real data")
    amount.add_argument("--long", action="store_true", help="run also the tests that take minutes")
    return parser.parse_known_args(arguments)


def marker_expression(options: argparse.Namespace) -> str:
    """Which tests to run, as pytest's option -m says it."""
    if options.long:
        return ""
    return "not long and not real_data" if options.fast else "not long"


def data_folder() -> Path:
    """Where the tests look for the evaluation meshes."""
    return Path(os.environ.get("SHAPEGOOGLE_DATA") or environment.ROOT.parent / "shared" / "data")


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


def run_tests(arguments: Sequence[str]) -> tuple[bool, str]:
    """Run pytest and show what it prints, except for its last line.

    Returns
    -------
    passed : bool
    closing_line : str
        Such as `12 passed in 3.45s`.
    """
    colour = ["--color=yes"] if sys.stdout.isatty() else []
    process = subprocess.Popen(
        [sys.executable, "-m", "pytest", *TEST_OPTIONS, *colour, *arguments],
        cwd=environment.ROOT,
        env={**os.environ, **ENVIRONMENT},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        errors="replace",
    )
    held_back = ""
    with process:
        for line in process.stdout or ():
            print(held_back, end="", flush=True)
            held_back = line
    return process.returncode == 0, held_back.rstrip()


def main(arguments: Sequence[str] | None = None) -> int:
    options, passed_on = parse_arguments(arguments)
    environment.enter(["demo", "test"])
    results = {name: run_check(name, command) for name, command in CHECKS.items()}
    folder = data_folder()
    state = "left out" if options.fast else f"use {folder}" if folder.is_dir() else f"skipped, no {folder}"
    print(f"tests on real data: {state}", flush=True)
    results["pytest"], closing_line = run_tests(["-m", marker_expression(options), *passed_on])
    failed = [name for name, passed in results.items() if not passed]
    print(f"FAILED: {', '.join(failed)}" if failed else f"All passed: {', '.join(results)}")
    print(closing_line, flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
