# SPDX-License-Identifier: MIT
"""Learn to describe pictures, and add it to the shipped default model.

    python -m benchmarks train-views --blend-meshes FOLDER

Learns whitening projections, of gradients and of the network's features, from pictures of procedural
creatures, objects and flat parts, and of those CC0 packs that may be learnt from, exported by `python -m
benchmarks blend-meshes`. No label is used, and no evaluation data. The bags of the model, and its identifier,
stay as they are.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from scipy.spatial.transform import Rotation

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.flat_parts import make_parts
from benchmarks.kinds.sets import DEVELOPMENT, pack_sets
from benchmarks.objects import OBJECT_KINDS, make_object
from benchmarks.training.models import SHIPPED
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import load_model
from shapegoogle_core.processes.progress import progress_bar
from shapegoogle_core.views import learn_views

__all__ = ["add_options", "run", "training_meshes"]


def training_meshes(blend_meshes: Path, individuals: int) -> Iterator[Mesh]:
    """Make or read all meshes to learn from.

    Parameters
    ----------
    blend_meshes : Path
        Folder of exported .blend meshes.
    individuals : int
        Of each kind of creature, in a pose of its own and turned at random, and of each kind of object.

    Yields
    ------
    mesh : Mesh
    """
    for kind in CREATURE_KINDS:
        for seed in range(individuals):
            mesh = make_creature(kind, seed, 2_000).pose(seed)
            turn = Rotation.random(random_state=seed).as_matrix()
            yield Mesh(mesh.vertices @ turn.T, mesh.faces, mesh.name)
    yield from (make_object(kind, seed) for kind in OBJECT_KINDS for seed in range(individuals))
    yield from (part.mesh for part in make_parts())
    for packs in pack_sets(blend_meshes):
        if packs.use == DEVELOPMENT:
            yield from (shape.mesh() for shape in packs.shapes)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--blend-meshes", type=Path, required=True, metavar="FOLDER", help="exported .blend meshes"
    )
    parser.add_argument(
        "--individuals",
        type=number_from(1),
        default=3,
        metavar="N",
        help="of each kind (3)",
    )
    parser.add_argument(
        "--output", type=Path, default=SHIPPED / "default.npz", metavar="FILE", help="model (%(default)s)"
    )


def run(options: argparse.Namespace) -> int:
    """Learn, and save the default model with it.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    meshes = list(training_meshes(options.blend_meshes, options.individuals))
    views = learn_views(progress_bar(meshes, "pictures", len(meshes)))
    load_model().with_parts(views=views).save(options.output)
    print(
        f"{options.output}: views of {len(meshes)} shapes, arrays {views.shape}; "
        f"{options.output.stat().st_size / 1e6:.2f} MB in all"
    )
    return 0
