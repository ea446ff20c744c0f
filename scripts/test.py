# SPDX-License-Identifier: MIT
"""Set up, then run everything that must pass: lint, format, types and tests.

    python3 scripts/test.py [--fast | --long] [--ci | --all-blenders] [options of pytest] [paths of tests]

Each part is a session of nox (`noxfile.py`). The add-on is tested on the bpy module of Blender 4.5, as
installed from the built zip, and in the window of a real Blender if the environment variable BLENDER names
one or there is one on PATH; with --ci also on bpy 4.2 and inside the real Blender, and the documentation is
built. What cannot run here is skipped with the reason. Exit code 0 if nothing failed.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from lib import bootstrap

__all__ = ["main"]

EVERYDAY = ("addon-4.5",)
CI = ("blender", *EVERYDAY, "addon-4.2")
ALL = (*CI, "addon-5.0", "addon-5.2")
# Sessions that run tests in these folders; tests elsewhere need no Blender.
FOLDERS = {"tests/extension": ("extension",), "tests/gui": ("window",)}


def sessions_for(
    paths: Sequence[str], addon: Sequence[str] = EVERYDAY, *, docs: bool = False
) -> list[list[str]]:
    """Choose the sessions to run.

    Parameters
    ----------
    paths : sequence of str
        Tests to run, relative to the repository; none: everything.
    addon : sequence of str, optional
        Sessions that test the add-on.
    docs : bool, optional
        Build the documentation, too, unless tests are named.

    Returns
    -------
    stages : list of list of str
        Sessions by stage, each with options of nox: the stages run one after the other, the sessions of a
        stage three at a time.
    """
    if not paths:
        # Before several sessions use them at once, the environments are made, and the zips built: with the
        # tool of one of the environments, where there is no real Blender.
        environments = [f"{name} --install-only" for name in addon if name != "blender"]
        # First what works in one process and often waits: `core` has several, and fills two processors
        # beside it and to the end.
        everything = ["window", *addon, "core", "checks", *(["docs"] if docs else []), "extension"]
        return [environments, ["build"], everything]
    folders = {**FOLDERS, "tests/addon": addon}
    wanted = {
        session
        for path in paths
        for session in next((folders[folder] for folder in folders if path.startswith(folder)), ("core",))
    }
    return [[session] for session in ("core", *addon, "extension", "window") if session in wanted]


def run_session(name: str, *, options: Sequence[str], live: bool) -> bool:
    """Run a session of nox; return whether it passed or was skipped.

    Parameters
    ----------
    name : str
        Perhaps with options of nox.
    options : sequence of str
        For pytest.
    live : bool
        Show every line at once, not all of them at the end.
    """
    command = [*bootstrap.nox("--session", *name.split()), "--", *options]
    result = subprocess.run(
        command,
        cwd=bootstrap.ROOT,
        stdin=subprocess.DEVNULL,
        stdout=None if live else subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        check=False,
    )
    # In one piece: another session may be printing, too.
    sys.stdout.write(result.stdout or "")
    sys.stdout.flush()
    return result.returncode == 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the checks and tests.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line when left out.

    Returns
    -------
    exit_code : int
    """
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").split("\n")[0],
        epilog="All other arguments go to pytest.",
        allow_abbrev=False,
    )
    amount = parser.add_mutually_exclusive_group()
    amount.add_argument("--fast", action="store_true", help="leave out tests on real data")
    amount.add_argument("--long", action="store_true", help="run the tests that take minutes, too")
    blenders = parser.add_mutually_exclusive_group()
    for name, sessions, where in (
        ("--ci", CI, "also on bpy 4.2 and inside the real Blender; build the documentation"),
        ("--all-blenders", ALL, "on all supported bpy modules, too"),
    ):
        blenders.add_argument(
            name, dest="addon", action="store_const", const=sessions, help=f"test the add-on {where}"
        )
    options, others = parser.parse_known_args(arguments)
    # With everything that a session needs: several of them run at a time, and must not install at once.
    bootstrap.enter(["benchmark", "demo", "serve", "test", *(["docs"] if options.addon else [])])

    marker = "" if options.long else "not long and not real_data" if options.fast else "not long"
    data = Path(os.environ.get("SHAPEGOOGLE_DATA") or bootstrap.ROOT.parent / "shared" / "data")
    if not options.fast and not data.is_dir():
        print(f"Tests on real data are skipped: there is no {data}", flush=True)
    paths = [word for word in others if (bootstrap.ROOT / word.partition("::")[0]).exists()]
    started = time.monotonic()
    passed: dict[str, bool] = {}
    for stage in sessions_for(paths, options.addon or EVERYDAY, docs=bool(options.addon)):
        with ThreadPoolExecutor(3) as pool:
            # One session shows its progress, those beside it what they printed when they end.
            results = [
                pool.submit(
                    run_session,
                    name,
                    options=["-m", marker, *others],
                    live=len(stage) == 1 or name == "core",
                )
                for name in stage
            ]
            passed |= {name: result.result() for name, result in zip(stage, results, strict=True)}
    failed = [name for name, good in passed.items() if not good]
    print(
        f"{time.monotonic() - started:.0f} s; " + (f"FAILED: {', '.join(failed)}" if failed else "all passed")
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
