# SPDX-License-Identifier: MIT
"""Measure times and memory, and compare spectra with those of other packages.

    python -m benchmarks speed [--sections NAME,…] [--sizes N,…] [--repeats N] [--keep FOLDER]
                               [--output FOLDER]

spectra     eigenpairs from vertices and faces, compared with LaPy (with and without CHOLMOD) and pyfmaps
describing  from a file to a signature, stage by stage
search      codes and libraries by their size
kinds       searches, and the kinds of the best 10 and 50 matches, compared with describing the query
walk        the neighbour graph: adding shapes, and the walk in a search
indexing    one worker compared with two, memory over a long run
blender     waiting times in Blender; needs the module bpy

Each section has its own default sizes and repeats; the docstring of its module in `benchmarks/speed` has the
details. In "spectra" the contestants take turns in one process on one thread, and medians are compared:
ratios above 1 are slower than this package. The other packages are measured if they are installed:
pip install -e '.[benchmark,peers]'. Each row is printed as a line of JSON; with --output the folder gets
speed-SECTION.json and speed-SECTION.png. All sections together take more than an hour.

The exit code is 1 if a section failed.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import tempfile
import traceback
from pathlib import Path

from benchmarks.speed.measuring import Options, installed
from benchmarks.speed.reporting import line, write_figure, write_rows

__all__ = ["add_options", "run"]

SECTIONS = ("spectra", "describing", "search", "kinds", "walk", "indexing", "blender")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--sections",
        type=_sections,
        default=SECTIONS,
        metavar="NAME,…",
        help=f"some of {', '.join(SECTIONS)}",
    )
    parser.add_argument("--sizes", type=_sizes, metavar="N,…", help="numbers of vertices, or of shapes")
    parser.add_argument(
        "--repeats", type=_positive, metavar="N", help="repetitions of which the median is taken"
    )
    parser.add_argument(
        "--library", type=Path, metavar="FILE", help="a real library, for the recall of search"
    )
    parser.add_argument(
        "--keep", type=Path, metavar="FOLDER", help="for the libraries of kinds, used again by the next run"
    )
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="for the .json and .png files")


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
    """Measure the sections one after the other; one that fails does not stop the others.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    # Before numpy is imported: threadpoolctl does not reach every library.
    os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    failed = []
    for section in options.sections:
        try:
            _measure(section, options)
        except Exception:
            traceback.print_exc()
            failed.append(section)
    for section in failed:
        print(f"the section {section!r} failed; see above", file=sys.stderr)
    return 1 if failed else 0


def _measure(section: str, options: argparse.Namespace) -> None:
    """Measure a section, print its rows and write its files."""
    print(f"\n{section}", flush=True)
    module = importlib.import_module(f"benchmarks.speed.{section}")
    if options.output is not None:
        options.output.mkdir(parents=True, exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory(dir=options.output) as folder:
        asked = Options(
            options.sizes or module.SIZES,
            options.repeats or module.REPEATS,
            Path(folder),
            options.library,
            options.keep,
        )
        for row in module.measure(asked):
            rows.append(row)
            print(line(row), flush=True)
    if options.output is not None:
        print(f"wrote {write_rows(section, rows, options.output)}")
        if installed("matplotlib"):
            print(f"wrote {write_figure(section, module.draw(rows), options.output)}")
        else:
            print("matplotlib is not installed, so there is no figure", file=sys.stderr)
