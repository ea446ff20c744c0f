# SPDX-License-Identifier: MIT
"""Write shapes to develop on: null shapes, their poses and unrelated shapes.

    python -m benchmarks development-set --output DEV [--blend-meshes FOLDER]
    python -m benchmarks retrieval --nulls DEV/nulls --queries DEV/poses --negatives DEV/negatives

Every choice of the method is made on such shapes, never on the evaluation data. The null shapes are
procedural creatures of all kinds, with other seeds than the training shapes. The unrelated shapes include
three more individuals of each kind, which differ in proportions only, and with --blend-meshes the CC0 models
exported by `python -m benchmarks blend-meshes`. All are rotated at random, because nothing may depend on
which way is up.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import trimesh
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.errors import BenchmarkError
from shapegoogle_core.mesh import Mesh, read_mesh

__all__ = ["add_options", "run"]

# The shipped models are trained on seeds from 0 on.
FIRST_SEED = 100
RIVALS = 3
POSES = 5


def _write(mesh: Mesh, path: Path, seed: int) -> None:
    turn = Rotation.random(random_state=seed).as_matrix()
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.Trimesh(mesh.vertices @ turn.T, mesh.faces, process=False).export(path)


def _write_creatures(output: Path, first_seed: int) -> int:
    written = 0
    for number, kind in enumerate(tqdm(sorted(CREATURE_KINDS), "creatures", disable=None)):
        for individual in range(1 + RIVALS):
            creature = make_creature(kind, first_seed + individual)
            name = f"{kind.replace(' ', '-')}{first_seed + individual}"
            folder = output / ("negatives" if individual else "nulls")
            _write(creature.pose(0), folder / f"{name}.ply", seed=1000 * number + individual)
            written += 1
            for pose in range(1, 1 + POSES) if individual == 0 else ():
                path = output / "poses" / f"{name}.isometry.{pose}.ply"
                _write(creature.pose(pose), path, seed=1000 * number + 100 + pose)
                written += 1
    return written


def _write_blends(output: Path, folder: Path) -> int:
    with (folder / "meshes.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] != "posed_characters"]
    for number, row in enumerate(rows):
        _write(read_mesh(folder / row["file"]), output / "negatives" / row["file"], seed=number)
    return len(rows)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("--output", type=Path, required=True, metavar="FOLDER", help="new or empty folder")
    parser.add_argument("--blend-meshes", type=Path, metavar="FOLDER", help="exported .blend meshes")
    parser.add_argument(
        "--seed",
        type=int,
        default=FIRST_SEED,
        metavar="N",
        help="of the first individual of each kind (%(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Write the shapes.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int

    Raises
    ------
    BenchmarkError
        If the folder is not empty.
    """
    if options.output.exists() and any(options.output.iterdir()):
        raise BenchmarkError(
            f"'{options.output}' is not empty; name a new folder, because shapes of two sets would mix"
        )
    written = _write_creatures(options.output, options.seed)
    if options.blend_meshes:
        written += _write_blends(options.output, options.blend_meshes)
    print(f"{options.output}: {written} shapes")
    return 0
