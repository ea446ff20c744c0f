# SPDX-License-Identifier: MIT
"""Query a library of procedural creatures with point clouds of them, as scanners measure them.

    python -m benchmarks point-clouds [--kinds N] [--individuals N]

For each kind of scan: the share that finds its own mesh first and among ten, and the relative difference
between the heat kernel signature at a point of the scan and that of the mesh at the nearest vertex (median
over points, then over shapes).
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from benchmarks.creatures import CREATURE_KINDS, make_creature
from shapegoogle_core import Library, Mesh, heat_kernel_signature, load_model
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.mesh import face_areas
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.working_shape import WorkingShape, working_shape

__all__ = ["add_options", "run"]

# The shipped models were trained on the seeds 0 to 7.
FIRST_SEED = 100
TIMES = np.array([64, 256, 1024, 4096]) / 40_000
# Number of points, standard deviation of the noise in diagonals, density at the sparse end relative to the
# dense one.
SCANS = (
    (2_000, 0.0, 1.0),
    (5_000, 0.0, 1.0),
    (10_000, 0.0, 1.0),
    (50_000, 0.0, 0.1),
    (5_000, 0.003, 0.1),
    (10_000, 0.005, 0.1),
    (50_000, 0.01, 0.1),
)


def scan(mesh: Mesh, count: int, noise: float, sparse: float, seed: int) -> Mesh:
    """Sample random points of a surface, sparser towards one side, and add noise."""
    random = np.random.default_rng(seed)
    corners = mesh.vertices[mesh.faces]
    direction = random.standard_normal(3)
    height = corners.mean(axis=1) @ direction
    density = face_areas(mesh) * (sparse + (1 - sparse) * (height - height.min()) / np.ptp(height))
    face = random.choice(len(corners), count, p=density / density.sum())
    weights = random.dirichlet(np.ones(3), count)
    points = np.einsum("nk,nki->ni", weights, corners[face])
    diagonal = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    return Mesh(points + noise * diagonal * random.standard_normal(points.shape), name=mesh.name)


def signature_difference(shape: WorkingShape, other: WorkingShape) -> FloatArray:
    """Compute the median relative difference between signatures at points and at another shape's nearest."""
    points, vertices = (each.placement.restore(each.mesh).vertices for each in (shape, other))
    _, nearest = KDTree(vertices).query(points)
    known = heat_kernel_signature(other.spectrum, TIMES)[nearest]
    found = heat_kernel_signature(shape.spectrum, TIMES)
    return np.asarray(np.median(np.abs(found / known - 1), axis=0))


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--kinds",
        type=number_from(1),
        default=len(CREATURE_KINDS),
        metavar="N",
        help="kinds of creatures (%(default)s)",
    )
    parser.add_argument(
        "--individuals",
        type=number_from(1),
        default=3,
        metavar="N",
        help="of each kind in the library (%(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Query with all kinds of scans and print the table.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    model = load_model()
    kinds = sorted(CREATURE_KINDS)[: options.kinds]
    seeds = range(FIRST_SEED, FIRST_SEED + options.individuals)
    meshes = {f"{kind} {seed}": make_creature(kind, seed).pose(0) for kind in kinds for seed in seeds}
    asked = [f"{kind} {FIRST_SEED}" for kind in kinds]
    known = {name: working_shape(model.settings, meshes[name]) for name in asked}
    with tempfile.TemporaryDirectory() as folder, Library.open(Path(folder, "l.sglib"), model) as library:
        for name, mesh in meshes.items():
            library.add(mesh, name=name, source=name)
        print(f"{len(asked)} scans of each kind among {len(meshes)} meshes")
        print(
            "points   noise  sparse  first  in ten  HKS difference at t = "
            + ", ".join(f"{t:.3g}" for t in TIMES)
        )
        for count, noise, sparse in SCANS:
            ranks, differences = [], []
            for name in asked:
                points = scan(meshes[name], count, noise, sparse, seed=1)
                found = [match.name for match in library.query(points, top=len(meshes))]
                ranks.append(found.index(name) + 1)
                differences.append(signature_difference(working_shape(model.settings, points), known[name]))
            first, in_ten = (np.mean(np.array(ranks) <= most) for most in (1, 10))
            figures = "  ".join(f"{value:6.3f}" for value in np.median(differences, axis=0))
            print(f"{count:6,} {noise:7.3f} {sparse:7.2f} {first:6.2f} {in_ten:7.2f}  {figures}", flush=True)
    return 0
