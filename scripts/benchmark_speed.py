#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measure how fast things are, against what others use for them.

    python3 scripts/benchmark_speed.py [--sections spectra,…] [--sizes 1000,…] [--repeats 5] [--output FOLDER]

spectra     eigenpairs from vertices and faces, against LaPy (with and without CHOLMOD) and pyfmaps
describing  from a file to a signature, stage by stage (speed_describe.py)
search      codes and libraries against their size, with numpy and with faiss (speed_search.py)
indexing    one worker against two, memory over a long run (speed_indexing.py)
blender     what people wait for in Blender (speed_blender.py: bpy, or the Blender in BLENDER or on PATH)

In "spectra" contestants take turns in one process on one thread, and medians are compared: ratios above 1 are
slower than this package. The others are measured if they are installed (the extra "peers"). All other
sections are scripts of their own, with their own sizes unless --sizes says others, and print a line of JSON
for each row. With --output the folder gets all tables as JSON and a plot for each section. All of it takes
more than an hour. Exit code 0, 1 if a section failed, or 2 for wrong usage.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import environment
from speed import spectra
from speed.measuring import Options, Row
from speed.reporting import table, write_report

RACES: dict[str, Callable[[Options], Iterator[Row]]] = {"spectra": spectra.measure}
SCRIPTS = {
    "describing": "speed_describe.py",
    "search": "speed_search.py",
    "indexing": "speed_indexing.py",
    "blender": "speed_blender.py",
}
SECTIONS = (*RACES, *SCRIPTS)
SIZES = (1_000, 10_000, 30_000, 100_000)


def parse_arguments(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sections", type=_sections, default=SECTIONS, metavar="NAME,…")
    parser.add_argument("--sizes", type=_sizes, metavar="N,…", help="numbers of vertices, or of shapes")
    parser.add_argument("--repeats", type=_positive, default=5, metavar="N")
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="where to write speed.json and plots")
    return parser.parse_args(arguments)


def _sections(text: str) -> tuple[str, ...]:
    names = tuple(text.split(","))
    for name in names:
        if name not in SECTIONS:
            raise argparse.ArgumentTypeError(
                f"there is no section {name!r}; choose from {', '.join(SECTIONS)}"
            )
    return names


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return int(text)


def _sizes(text: str) -> tuple[int, ...]:
    return tuple(_positive(part) for part in text.split(","))


def run(options: argparse.Namespace) -> int:
    """Measure the sections, print the tables and write the report."""
    from threadpoolctl import threadpool_limits

    rows: list[Row] = []
    with threadpool_limits(1):
        for name in RACES.keys() & set(options.sections):
            for row in RACES[name](Options(options.sizes or SIZES, options.repeats)):
                rows.append(row)
                print(
                    f"{name}: {row.task}, {row.size:,}: {row.contestant} {row.seconds:.3f} s", file=sys.stderr
                )
    if rows:
        print(table(rows))
        if options.output is not None:
            for path in write_report(rows, options.output):
                print(f"wrote {path}")
    failed = [name for name in options.sections if name in SCRIPTS and not run_script(name, options)]
    for name in failed:
        print(f"the section {name!r} failed; see above", file=sys.stderr)
    return 1 if failed else 0


def run_script(section: str, options: argparse.Namespace) -> bool:
    """Run the script of a section; what it prints goes where this script's does."""
    print(f"\n{section}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(Path(__file__).with_name(SCRIPTS[section]))]
        command += [str(options.output or folder), "--repeats", str(options.repeats)]
        if options.sizes:
            command += ["--sizes", *map(str, options.sizes)]
        return subprocess.run(command, check=False).returncode == 0


def main() -> int:
    options = parse_arguments()
    # Before any library that reads it is loaded; threadpoolctl does not reach every one.
    os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment.enter(("benchmark", "peers"))
    return run(options)


if __name__ == "__main__":
    sys.exit(main())
