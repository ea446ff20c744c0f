# SPDX-License-Identifier: MIT
"""Compare how the product and other readers read the model files of folders.

    python -m benchmarks files FOLDER... --output DIR [--jobs N] [--blender PROGRAM]

Every file is read by the product, trimesh, meshio and, where there is one, Blender, each in processes of its
own with a limit of time and memory; Blender reads glTF files without their animations. Area, extent, and the
numbers of vertices (after welding) and triangles are compared; the objects of a .blend file are compared with
what Blender itself evaluates. DIR gets readings.csv (what every reader made of every file), verdicts.csv (one
line for each file or object) and summary.md. The folders are only read. The exit code is 1 if the product
failed on a file other than with its own error, crashed or took too long.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.errors import BenchmarkError
from benchmarks.experiments.files.in_processes import read_in_pool
from benchmarks.experiments.files.reading import (
    BLENDER,
    BLENDER_SUFFIXES,
    READERS,
    SUFFIXES,
    Limits,
    Reading,
    readers_of,
)
from benchmarks.experiments.files.report import summary, write_readings, write_verdicts
from benchmarks.experiments.files.through_blender import find_blender, read_through_blender
from benchmarks.experiments.files.verdicts import Verdict, judge
from shapegoogle_core.cli.arguments import number_from

__all__ = ["add_options", "find_models", "run"]


def find_models(folders: Sequence[Path]) -> list[Path]:
    """Find all files with a suffix that a reader knows.

    Parameters
    ----------
    folders : sequence of Path

    Returns
    -------
    paths : list of Path
        Each once, sorted.

    Raises
    ------
    BenchmarkError
        If a folder does not exist, or there are no such files.
    """
    for folder in folders:
        if not folder.is_dir():
            raise BenchmarkError(f"'{folder}' is not a folder; name folders with model files")
    found = {path for folder in folders for path in folder.rglob("*") if path.suffix.lower() in SUFFIXES}
    paths = sorted(path for path in found if path.is_file())
    if not paths:
        raise BenchmarkError(
            f"'{folders[0]}' has no model files ({', '.join(sorted(SUFFIXES))}); name another folder"
        )
    return paths


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--output", type=Path, required=True, metavar="DIR", help="folder for the tables")
    parser.add_argument(
        "--jobs", type=number_from(1), default=2, metavar="N", help="processes of each reader (%(default)s)"
    )
    parser.add_argument(
        "--time-limit",
        type=number_from(1),
        default=60,
        metavar="SECONDS",
        help="that a reader may take for a file (%(default)s)",
    )
    parser.add_argument(
        "--memory-limit",
        type=number_from(1),
        default=4096,
        metavar="MB",
        help="that a reader may need for a file, on Linux (%(default)s)",
    )
    parser.add_argument(
        "--blender",
        default=os.environ.get("BLENDER"),
        metavar="PROGRAM",
        help="a Blender, or a Python that has the module bpy (environment variable BLENDER, or this Python)",
    )


def run(options: argparse.Namespace) -> int:
    """Read all files with all readers and write the tables.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    paths = find_models(options.folders)
    blender = find_blender(options.blender)
    limits = Limits(options.jobs, options.time_limit, options.memory_limit)
    known = {path: readers_of(path.suffix.lower(), blender is not None) for path in paths}
    readings: dict[Path, list[Reading]] = {path: [] for path in paths if known[path]}
    for reader in READERS:
        chosen = [path for path in paths if reader in known[path]]
        through = [path for path in chosen if reader == BLENDER or path.suffix.lower() in BLENDER_SUFFIXES]
        here = [path for path in chosen if path not in set(through)]
        found = read_in_pool(reader, here, limits) if here else []
        if through and blender is not None:
            found += read_through_blender(reader, through, limits, blender)
        for reading in found:
            readings[reading.path].append(reading)
        # After every reader, since reading thousands of files takes hours.
        verdicts = _write(readings, options.folders, options.output)
    print((options.output / "summary.md").read_text(encoding="utf-8").split("\n## ")[0])
    return int(any(verdict.verdict == "fails" for verdict in verdicts))


def _write(
    readings: Mapping[Path, Sequence[Reading]], folders: Sequence[Path], output: Path
) -> list[Verdict]:
    """Write the tables and the summary; returns the verdicts."""
    verdicts = [verdict for of_a_file in readings.values() for verdict in judge(of_a_file)]
    folder = Path(os.path.commonpath([each.absolute() for each in folders]))
    output.mkdir(parents=True, exist_ok=True)
    every = [reading for of_a_file in readings.values() for reading in of_a_file]
    write_readings(output / "readings.csv", every, folder)
    write_verdicts(output / "verdicts.csv", verdicts, folder)
    page = summary(verdicts, folder)
    (output / "summary.md").write_text(page, encoding="utf-8", errors="backslashreplace")
    return verdicts
