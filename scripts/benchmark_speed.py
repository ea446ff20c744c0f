#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measure how fast things are, against what others use for them.

    python3 scripts/benchmark_speed.py [--sections spectra,…] [--sizes 1000,…] [--repeats 5] [--output FOLDER]

spectra     eigenpairs from vertices and faces, against LaPy (with and without CHOLMOD) and pyfmaps

Contestants take turns in one process on one thread, and medians are compared: ratios above 1 are slower
than this package. The others are measured if they are installed (the extra "peers"). With --output the folder
gets speed.json and a plot for each section. Exit code 0, or 2 for wrong usage.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import environment
from speed import spectra
from speed.measuring import Options, Row
from speed.reporting import table, write_report

SECTIONS: dict[str, Callable[[Options], Iterator[Row]]] = {"spectra": spectra.measure}
SIZES = (1_000, 10_000, 30_000, 100_000)


def parse_arguments(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sections", type=_sections, default=tuple(SECTIONS), metavar="NAME,…")
    parser.add_argument(
        "--sizes", type=_sizes, default=SIZES, metavar="N,…", help="such as numbers of vertices"
    )
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
    """Measure the sections on one thread, print the table and write the report."""
    from threadpoolctl import threadpool_limits

    rows: list[Row] = []
    with threadpool_limits(1):
        for name in options.sections:
            for row in SECTIONS[name](Options(options.sizes, options.repeats)):
                rows.append(row)
                print(
                    f"{name}: {row.task}, {row.size:,}: {row.contestant} {row.seconds:.3f} s", file=sys.stderr
                )
    print(table(rows))
    if options.output is not None:
        for path in write_report(rows, options.output):
            print(f"wrote {path}")
    return 0


def main() -> int:
    options = parse_arguments()
    # Before any library that reads it is loaded; threadpoolctl does not reach every one.
    os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment.enter(("benchmark", "peers"))
    return run(options)


if __name__ == "__main__":
    sys.exit(main())
