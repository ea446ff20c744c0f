# SPDX-License-Identifier: MIT
"""Train the models that ship with the package: "default" and "paper".

Training shapes are the procedural creatures of `benchmarks.creatures`, and, with
--blend-meshes, the CC0 models that `benchmarks/training/blend_meshes.py` wrote. Never evaluation data.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shapegoogle_core.model.training import TrainingShape

REPOSITORY = Path(__file__).resolve().parents[2]


def creature_shapes(individuals: int, poses: int) -> list[TrainingShape]:
    from benchmarks.creatures import CREATURE_KINDS, make_creature
    from shapegoogle_core.model.training import TrainingShape

    shapes = []
    for kind in sorted(CREATURE_KINDS):
        for seed in range(individuals):
            creature = make_creature(kind, seed)
            meshes = tuple(creature.pose(pose) for pose in range(poses))
            shapes.append(TrainingShape(f"{kind}-{seed}", meshes))
    return shapes


def blend_shapes(folder: Path, poses: int) -> list[TrainingShape]:
    from shapegoogle_core.mesh import read_mesh
    from shapegoogle_core.model.training import TrainingShape

    with (folder / "meshes.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] != "posed_characters"]
    files: dict[str, list[Path]] = {}
    for row in rows:
        files.setdefault(row["shape"], []).append(folder / row["file"])
    return [
        TrainingShape(shape, tuple(read_mesh(path) for path in paths[:poses]))
        for shape, paths in sorted(files.items())
    ]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--preset", action="append", choices=["default", "paper"], help="default: both")
    parser.add_argument("--blend-meshes", type=Path, help="folder made by export_blend_meshes.py")
    parser.add_argument("--individuals", type=int, default=8, help="of each kind of creature")
    parser.add_argument("--poses", type=int, default=3, help="of each shape that has poses")
    parser.add_argument("--versions", type=int, default=8, help="transformed versions of each shape")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--output", type=Path, default=REPOSITORY / "shapegoogle_core" / "model" / "shipped")
    arguments = parser.parse_args()

    from shapegoogle_core.model import PRESETS
    from shapegoogle_core.model.training import train_model
    from shapegoogle_core.processes.progress import progress_bar

    shapes = creature_shapes(arguments.individuals, arguments.poses)
    sources = f"{len(shapes)} procedural creatures"
    if arguments.blend_meshes:
        blends = blend_shapes(arguments.blend_meshes, arguments.poses)
        shapes += blends
        sources += f" and {len(blends)} CC0 models by Quaternius"
    arguments.output.mkdir(parents=True, exist_ok=True)
    for preset in arguments.preset or ["default", "paper"]:
        started = time.monotonic()
        model = train_model(
            shapes,
            PRESETS[preset],
            versions=arguments.versions,
            jobs=arguments.jobs,
            trained_on=f"{sources}, {arguments.poses} poses and {arguments.versions} versions of each",
            progress=progress_bar,
        )
        path = arguments.output / f"{preset}.npz"
        model.save(path)
        print(f"{path}: {path.stat().st_size / 1e6:.2f} MB, {time.monotonic() - started:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
