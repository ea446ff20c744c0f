# SPDX-License-Identifier: MIT
"""Train the models that ship with the package, "default" and "paper".

    python -m benchmarks train [--preset NAME] [--blend-meshes FOLDER]

Training shapes are procedural creatures and, with --blend-meshes, the CC0 models exported by
`python -m benchmarks blend-meshes`; never evaluation data.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

from benchmarks.creatures import CREATURE_KINDS, make_creature
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.model import PRESETS
from shapegoogle_core.model.training import TrainingShape, train_model
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["add_options", "run"]

SHIPPED = Path(__file__).resolve().parents[2] / "shapegoogle_core" / "model" / "shipped"


def creature_shapes(individuals: int, poses: int) -> list[TrainingShape]:
    """Make individuals of each kind of creature, each in several poses.

    Parameters
    ----------
    individuals : int
        Of each kind.
    poses : int
        Of each individual.

    Returns
    -------
    shapes : list of TrainingShape
    """
    shapes = []
    for kind in sorted(CREATURE_KINDS):
        for seed in range(individuals):
            creature = make_creature(kind, seed)
            meshes = tuple(creature.pose(pose) for pose in range(poses))
            shapes.append(TrainingShape(f"{kind}-{seed}", meshes))
    return shapes


def blend_shapes(folder: Path, poses: int) -> list[TrainingShape]:
    """Read exported .blend meshes, without the posed characters, which are evaluation data.

    Parameters
    ----------
    folder : Path
    poses : int
        Most poses of each shape.

    Returns
    -------
    shapes : list of TrainingShape
    """
    with (folder / "meshes.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] != "posed_characters"]
    files: dict[str, list[Path]] = {}
    for row in rows:
        files.setdefault(row["shape"], []).append(folder / row["file"])
    return [
        TrainingShape(shape, tuple(read_mesh(path) for path in paths[:poses]))
        for shape, paths in sorted(files.items())
    ]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--preset", action="append", choices=["default", "paper"], help="model to train (both)"
    )
    parser.add_argument("--blend-meshes", type=Path, metavar="FOLDER", help="exported .blend meshes")
    for name, default, text in (
        ("--individuals", 8, "of each kind of creature (8)"),
        ("--poses", 3, "of each shape that has poses (3)"),
        ("--versions", 8, "transformed versions of each shape (8)"),
        ("--jobs", 2, "worker processes (2)"),
    ):
        parser.add_argument(name, type=number_from(1), default=default, metavar="N", help=text)
    parser.add_argument("--output", type=Path, default=SHIPPED, metavar="FOLDER", help="(%(default)s)")


def run(options: argparse.Namespace) -> int:
    """Train the models and save them.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    shapes = creature_shapes(options.individuals, options.poses)
    sources = f"{len(shapes)} procedural creatures"
    if options.blend_meshes:
        blends = blend_shapes(options.blend_meshes, options.poses)
        shapes += blends
        sources += f" and {len(blends)} CC0 models by Quaternius"
    options.output.mkdir(parents=True, exist_ok=True)
    for preset in options.preset or ["default", "paper"]:
        started = time.monotonic()
        model = train_model(
            shapes,
            PRESETS[preset],
            versions=options.versions,
            jobs=options.jobs,
            trained_on=f"{sources}, {options.poses} poses and {options.versions} versions of each",
            progress=progress_bar,
        )
        path = options.output / f"{preset}.npz"
        model.save(path)
        print(f"{path}: {path.stat().st_size / 1e6:.2f} MB, {time.monotonic() - started:.0f} s")
    return 0
