# SPDX-License-Identifier: MIT
"""Measure how fast things are, against what others use for them.

    python -m benchmarks.speed.command [--sections NAME,…] [--sizes N,…] [--repeats N] [--output FOLDER]

spectra     eigenpairs from vertices and faces, against LaPy (with and without CHOLMOD) and pyfmaps
describing  from a file to a signature, stage by stage
search      codes and libraries against their size, with numpy and with faiss
indexing    one worker against two, memory over a long run
blender     what people wait for in Blender (the one in BLENDER or on PATH; speed_blender.py for a bpy module)

Each has its own sizes and repeats unless others are named; what exactly it measures is said in the module of
its name in `speed`. In "spectra" contestants take turns in one process on one thread, and medians are
compared: ratios above 1 are slower than this package. The others are measured if they are installed (the
extra "peers"). A line of JSON is printed for each row; with --output the folder gets speed-SECTION.json and
speed-SECTION.png. All of it takes more than an hour.

Exit code 0, 1 if a section failed, or 2 for wrong usage.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import tempfile
import traceback
from collections.abc import Sequence
from pathlib import Path

from benchmarks.speed.measuring import Options
from benchmarks.speed.reporting import line, write_figure, write_rows

SECTIONS = ("spectra", "describing", "search", "indexing", "blender")


def parse_arguments(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sections", type=_sections, default=SECTIONS, metavar="NAME,…")
    parser.add_argument("--sizes", type=_sizes, metavar="N,…", help="numbers of vertices, or of shapes")
    parser.add_argument("--repeats", type=_positive, metavar="N", help="times are medians of so many")
    parser.add_argument("--library", type=Path, metavar="FILE", help="a real one, for the recall of search")
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="where to write figures and pictures")
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
    """Measure the sections one after the other; one that fails does not stop the others."""
    failed = []
    for section in options.sections:
        try:
            measure(section, options)
        except Exception:
            traceback.print_exc()
            failed.append(section)
    for section in failed:
        print(f"the section {section!r} failed; see above", file=sys.stderr)
    return 1 if failed else 0


def measure(section: str, options: argparse.Namespace) -> None:
    """Measure a section, print its rows and write its files."""
    print(f"\n{section}", flush=True)
    # Imported now: they need what is installed only in the environment that `main` has entered.
    module = importlib.import_module(f"benchmarks.speed.{section}")
    if options.output is not None:
        options.output.mkdir(parents=True, exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory(dir=options.output) as folder:
        asked = Options(
            options.sizes or module.SIZES, options.repeats or module.REPEATS, Path(folder), options.library
        )
        for row in module.measure(asked):
            rows.append(row)
            print(line(row), flush=True)
    if options.output is not None:
        print(f"wrote {write_rows(section, rows, options.output)}")
        print(f"wrote {write_figure(section, module.draw(rows), options.output)}")


def main() -> int:
    options = parse_arguments()
    # Before any library that reads it is loaded; threadpoolctl does not reach every one.
    os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    return run(options)


if __name__ == "__main__":
    sys.exit(main())
