# SPDX-License-Identifier: MIT
"""Index a folder of .blend files, query it with posed characters, and time the sidebar's search.

    python -m benchmarks blend-library FOLDER [--poses NAME] [--jobs N]

Needs a Python with the module bpy. Prints the figures of docs/measurements/libraries.md: files indexed and
seconds for each; a second run; the share of the best matches of each posed character that are the same
character in another pose; the time of Find Similar for an object of 10,000 vertices in a library of 1,000
shapes. FOLDER is only read.
"""

from __future__ import annotations

import argparse
import json
import re
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from benchmarks.blender import enable_addon
from shapegoogle_core import Library
from shapegoogle_core.cli.arguments import number_from

__all__ = ["add_options", "index", "poses", "run", "search"]

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
SHAPES, VERTICES, REPEATS = 1_000, 10_000, 5
# The woman has two prefixes; hairstyles are not persons.
WOMAN, NO_PERSON = re.compile("^(Female|Woman)_"), "Hairstyle"


def run_script(script: str, *arguments: str | Path) -> tuple[int, str, str, float]:
    """Run one of the scripts of this repository; return exit code, output, errors and seconds."""
    started = time.monotonic()
    command = [sys.executable, str(SCRIPTS / f"{script}.py"), *map(str, arguments)]
    result = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)
    return result.returncode, result.stdout, result.stderr, time.monotonic() - started


def index(folder: Path, library: Path, jobs: int) -> None:
    """Index a folder twice and print the times.

    Parameters
    ----------
    folder : Path
    library : Path
        File that is written.
    jobs : int
        Worker processes.
    """
    files = len(list(folder.rglob("*.blend")))
    arguments = (folder, "--library", library, "--jobs", str(jobs))
    code, output, errors, seconds = run_script("index_library", *arguments)
    print(
        f"index: exit code {code}, {seconds:.1f} s, {seconds / max(files, 1):.3f} s for each of {files} files"
    )
    print(f"  {output.strip()}")
    print(
        "".join(f"  {line}\n" for line in errors.splitlines() if "failed" in line or "skipped" in line),
        end="",
    )
    code, output, _, seconds = run_script("index_library", *arguments)
    print(f"again: exit code {code}, {seconds:.1f} s\n  {output.strip()}")


def _person(path: str) -> str:
    return "woman" if WOMAN.match(Path(path).name) else "man"


def poses(folder: Path, name: str, library: Path) -> None:
    """Query with each pose, and count the best matches that are the same person.

    Parameters
    ----------
    folder : Path
    name : str
        Folder in it with the poses.
    library : Path
    """
    files = sorted(path for path in (folder / name).glob("*.blend") if NO_PERSON not in path.name)
    if not files:
        print(f"poses: no .blend files in {folder / name}")
        return
    count = {who: sum(_person(path.name) == who for path in files) - 1 for who in ("man", "woman")}
    code, output, _, _ = run_script(
        "query_library", *files, "--library", library, "--json", "--top", str(max(count.values()) + 1)
    )
    right = total = 0
    for record in map(json.loads, output.splitlines()):
        query = Path(record["query"])
        others = [match["source"] for match in record["matches"] if Path(match["source"]) != query.resolve()]
        best = others[: count[_person(query.name)]]
        found = [Path(path).resolve() in {file.resolve() for file in files} for path in best]
        hits = sum(
            known and _person(path) == _person(query.name) for known, path in zip(found, best, strict=True)
        )
        right, total = right + hits, total + len(best)
        if hits < len(best):
            print(f"  {query.name}: {hits} of {len(best)}")
    print(
        f"poses: exit code {code}, {right} of {total} best matches are the same person ({right / total:.1%})"
    )


def search(library_file: Path) -> None:
    """Time Find Similar in one Blender: the first call and later calls.

    Parameters
    ----------
    library_file : Path
        Its shapes fill a larger library.
    """
    import bpy

    addon = enable_addon()
    with tempfile.TemporaryDirectory() as folder:
        larger = Path(folder, "larger.sglib")
        with Library.open(library_file, read_only=True) as known:
            signatures = [
                (known.signature(shape.shape_id), shape.name, known.thumbnail(shape.shape_id))
                for shape in known.shapes()
            ]
            with Library.open(larger, known.model) as library:
                for number in range(SHAPES):
                    signature, name, thumbnail = signatures[number % len(signatures)]
                    # All different, as in a real library.
                    bags = signature.bags * (1 + 0.01 * (number // len(signatures)))
                    library.add_signature(
                        replace(signature, bags=bags), f"{name} {number}", "", "", thumbnail
                    )
        bpy.context.preferences.addons[addon.__name__].preferences.library = str(larger)
        seconds: list[float] = []
        for number in range(REPEATS + 1):
            _add_object(bpy, 0.01 * number)
            started = time.monotonic()
            bpy.ops.shape_google.find_similar()
            seconds.append(time.monotonic() - started)
        later = statistics.median(seconds[1:])
        print(
            f"Find Similar, {len(bpy.context.object.data.vertices):,} vertices, {SHAPES:,} shapes: "
            f"{seconds[0]:.2f} s the first time, then {later:.2f} s (median of {REPEATS})"
        )


def _add_object(bpy: Any, bump: float) -> None:
    """Add an object of `VERTICES` vertices; its shape depends on `bump`."""
    rows = round((VERTICES / 2) ** 0.5)
    bpy.ops.mesh.primitive_torus_add(
        major_segments=2 * rows, minor_segments=rows, minor_radius=0.4 + bump, major_radius=1.0
    )


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "folder", metavar="FOLDER", type=Path, help="searched for .blend files, with its sub-folders"
    )
    parser.add_argument(
        "--poses",
        metavar="NAME",
        default="posed_characters",
        help="folder in it with two persons in several poses (%(default)s)",
    )
    parser.add_argument(
        "--jobs", metavar="N", type=number_from(1), default=2, help="worker processes (%(default)s)"
    )


def run(options: argparse.Namespace) -> int:
    """Index, query and time.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "shapes.sglib")
        index(options.folder, library, options.jobs)
        poses(options.folder, options.poses, library)
        search(library)
    return 0
