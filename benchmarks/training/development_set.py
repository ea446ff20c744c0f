# SPDX-License-Identifier: MIT
"""Write shapes to develop on: null shapes, their poses and unrelated shapes, for `shapegoogle benchmark`.

    python3 -m benchmarks.training.development_set --output DEV [--blend-meshes FOLDER]
    shapegoogle benchmark --nulls DEV/nulls --queries DEV/poses --negatives DEV/negatives

Every choice of the method is made on such shapes, never on the evaluation data. The null shapes are
procedural creatures of all kinds, of other seeds than the trained ones; beside each stand three more of its
kind, which differ in proportions only. With --blend-meshes, the CC0 models that
`benchmarks/training/blend_meshes.py` wrote are among the unrelated shapes. All are turned at random: nothing
may rest on which way is up.
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shapegoogle_core.mesh import Mesh

# The default model is trained on seeds from 0 on.
FIRST_SEED = 100
RIVALS = 3
POSES = 5


def write(mesh: Mesh, path: Path, seed: int) -> None:
    import trimesh
    from scipy.spatial.transform import Rotation

    turn = Rotation.random(random_state=seed).as_matrix()
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.Trimesh(mesh.vertices @ turn.T, mesh.faces, process=False).export(path)


def write_creatures(output: Path, first_seed: int) -> int:
    from tqdm import tqdm

    from benchmarks.creatures import CREATURE_KINDS, make_creature

    written = 0
    for number, kind in enumerate(tqdm(sorted(CREATURE_KINDS), "creatures", disable=None)):
        for individual in range(1 + RIVALS):
            creature = make_creature(kind, first_seed + individual)
            name = f"{kind.replace(' ', '-')}{first_seed + individual}"
            folder = output / ("negatives" if individual else "nulls")
            write(creature.pose(0), folder / f"{name}.ply", seed=1000 * number + individual)
            written += 1
            for pose in range(1, 1 + POSES) if individual == 0 else ():
                path = output / "poses" / f"{name}.isometry.{pose}.ply"
                write(creature.pose(pose), path, seed=1000 * number + 100 + pose)
                written += 1
    return written


def write_blends(output: Path, folder: Path) -> int:
    from shapegoogle_core.mesh import read_mesh

    with (folder / "meshes.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] != "posed_characters"]
    for number, row in enumerate(rows):
        write(read_mesh(folder / row["file"]), output / "negatives" / row["file"], seed=number)
    return len(rows)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--output", type=Path, required=True, help="folder to write to")
    parser.add_argument("--blend-meshes", type=Path, help="folder made by export_blend_meshes.py")
    parser.add_argument(
        "--seed", type=int, default=FIRST_SEED, help="of the first individual of each kind (%(default)s)"
    )
    arguments = parser.parse_args()
    if arguments.output.exists() and any(arguments.output.iterdir()):
        parser.error(f"'{arguments.output}' is not empty; name a new folder, or shapes of two sets would mix")
    written = write_creatures(arguments.output, arguments.seed)
    if arguments.blend_meshes:
        written += write_blends(arguments.output, arguments.blend_meshes)
    print(f"{arguments.output}: {written} shapes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
