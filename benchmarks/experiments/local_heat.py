# SPDX-License-Identifier: MIT
"""Find creatures by parts of them in another pose, by local heat alone, without the rest of a search.

    python -m benchmarks local-heat [--individuals N] [--queries N] [--jobs N]
    python -m benchmarks local-heat --learn

Prints how often the right one of all wholes differs least from a third and from half of it in another pose,
and how often it is among the first few. Cuts are made through the creature in its other pose.

With --learn it writes the background in `shapegoogle_core/registration/heat`, and prints the covariance of
`agreement.py` there: differences between points of other creatures' parts and the nearest points of wholes.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import shapegoogle_core.registration.heat
from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.experiments.evidence_pairs import cut
from benchmarks.parallel import map_in_processes
from benchmarks.things import THING_KINDS, make_thing
from shapegoogle_core import Mesh, load_model
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.cli.text import say, table
from shapegoogle_core.mesh.drawing import draw_points
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.registration import (
    BACKGROUND_FILE,
    FEW_AMONG,
    BentPart,
    LocalHeat,
    farthest_points,
    heat_features,
    measure_local_heat,
)

__all__ = ["add_options", "run"]

Floats = NDArray[np.float64]

FIRST_SEED, FIRST_TRAINING_SEED, TRAINING_SEEDS = 8_000, 7_000, 2
SHARES = {"a third missing": 2 / 3, "half missing": 1 / 2}
TOP = (1, 5, 12, 40)
# As in `sample_surface`.
CLOUD, POINTS = 4_000, 1_200
HEAT_FOLDER = Path(shapegoogle_core.registration.heat.__file__).parent
# Outliers are cut off before a covariance is learnt.
OUTLIERS = (3, 97)


@dataclass(frozen=True, eq=False)
class Measured:
    """Local heat of a mesh, and where.

    Attributes
    ----------
    heat : LocalHeat
    places : (k, 3) array
        Its points in the coordinates of the mesh.
    unit : float
        √area in the unit of the mesh.
    """

    heat: LocalHeat
    places: Floats
    unit: float


@cache
def _settings() -> ModelSettings:
    return load_model().settings


def measure(mesh: Mesh) -> Measured:
    """Measure the local heat of a surface."""
    shape = working_shape(_settings(), mesh)
    assert shape.unsmoothed is not None
    surface = shape.unsmoothed.mesh
    faces, corners = draw_points(face_areas(surface), CLOUD, np.random.default_rng(0))
    vertices = surface.faces[faces].astype(np.int64)
    cloud = (surface.vertices[vertices] * corners[:, :, None]).sum(axis=1)
    chosen = farthest_points(cloud - cloud.mean(axis=0), POINTS)
    order = np.concatenate([chosen, np.delete(np.arange(CLOUD), chosen)])
    heat = measure_local_heat(shape.unsmoothed, shape.spectrum, vertices[order], corners[order], POINTS)
    places = shape.placement.restore(Mesh(cloud[chosen], np.empty((0, 3), np.int64))).vertices
    # With the precision of a library.
    heat = LocalHeat.from_bytes(heat.to_bytes())
    return Measured(heat, places, float(np.sqrt(surface.area)) / shape.placement.scale)


def _part(kind: str, seed: int, share: float) -> Mesh:
    random = np.random.default_rng([seed, len(kind), round(100 * share)])
    return cut(make_creature(kind, seed).pose(1), random.normal(size=3), share)


def whole_of(job: tuple[str, int]) -> Measured:
    """Measure a creature: its kind and its seed."""
    kind, seed = job
    return measure(make_creature(kind, seed).pose(0))


def thing_of(kind: str) -> Measured:
    """Measure a thing of a kind."""
    return measure(make_thing(kind, FIRST_TRAINING_SEED))


def part_of(job: tuple[str, int, float]) -> Measured:
    """Measure a part of a creature in another pose: kind, seed, share of the area."""
    return measure(_part(*job))


def residuals_of(job: tuple[str, int, float]) -> tuple[Floats, NDArray[np.int64]]:
    """Compare a part's points with the nearest ones of its whole, at the size at which they differ least."""
    kind, seed, _ = job
    creature = make_creature(kind, seed)
    rest, posed = creature.pose(0), creature.pose(1)
    whole, part = measure(rest), part_of(job)
    same = cKDTree(posed.vertices).query(part.places)[1]
    nearest = cKDTree(whole.places).query(rest.vertices[same])[1]
    among, _ = heat_features(whole.heat)
    found = []
    for size in part.unit / whole.unit * np.linspace(0.9, 1.1, 21):
        own, known = heat_features(part.heat, size)
        differences = own - among[nearest]
        error = float(np.median(np.abs(differences[known >= known.max(), 1:])))
        found.append((error, differences, known))
    _, differences, known = min(found, key=lambda each: each[0])
    return differences, known


def learn_covariance(residuals: Sequence[tuple[Floats, NDArray[np.int64]]]) -> Floats:
    """Learn how the features of the same point differ by chance, each pair of them where both are known."""
    differences = np.concatenate([each for each, _ in residuals])
    known = np.concatenate([each for _, each in residuals])
    low, high = np.percentile(differences[known > 0], OUTLIERS, axis=0)
    clipped = np.clip(differences, low, high)
    covariance = np.empty((differences.shape[1],) * 2)
    for row, column in np.ndindex(covariance.shape):
        both = known >= max(row, column, 1)
        covariance[row, column] = (clipped[both, row] * clipped[both, column]).mean()
    return covariance


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    for name, default, text in (
        ("--individuals", 12, "of each of 31 kinds (12: 372 wholes)"),
        ("--queries", 62, "creatures that are cut and bent (62)"),
        ("--jobs", 2, "worker processes (2)"),
    ):
        parser.add_argument(name, type=number_from(1), default=default, metavar="N", help=text)
    parser.add_argument("--learn", action="store_true", help="make background and covariance instead")


def run(options: argparse.Namespace) -> int:
    """Measure wholes and parts, compare them and print the table.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    if options.learn:
        return _learn(options.jobs)
    names = [(kind, FIRST_SEED + number) for number in range(options.individuals) for kind in CREATURE_KINDS]
    wholes = [measured.heat for measured in map_in_processes(whole_of, names, options.jobs, "creatures")]
    rows = [["", "MRR", *(f"first {top}" for top in TOP)]]
    for sort, share in SHARES.items():
        asked = [(kind, seed, share) for kind, seed in names[: options.queries]]
        ranks = []
        for right, part in enumerate(map_in_processes(part_of, asked, options.jobs, sort)):
            found = BentPart(part.heat).differences(dict(enumerate(wholes)))
            own = found.get(right, np.inf)
            ranks.append(1 + sum(difference < own for difference in found.values()))
        places = np.array(ranks)
        rows.append([sort, f"{(1 / places).mean():.3f}", *(f"{(places <= top).mean():.0%}" for top in TOP)])
    say(f"{len(wholes):,} wholes, {min(options.queries, len(names))} queries of each sort")
    for line in table(rows, "<" + ">" * (1 + len(TOP))):
        say(line)
    return 0


def _learn(jobs: int) -> int:
    seeds = range(FIRST_TRAINING_SEED, FIRST_TRAINING_SEED + TRAINING_SEEDS)
    # The creatures that the covariance is learnt from, and a thing of each kind.
    creatures = map_in_processes(whole_of, list(product(CREATURE_KINDS, seeds)), jobs, "creatures")
    things = map_in_processes(thing_of, THING_KINDS, jobs, "things")
    heats = [measured.heat.first(FEW_AMONG) for measured in (*creatures, *things)]
    rows = np.stack([np.frombuffer(heat.to_bytes(), np.uint8) for heat in heats])
    np.savez_compressed(HEAT_FOLDER / BACKGROUND_FILE, shapes=rows)
    learnt = [(kind, seed, share) for kind in CREATURE_KINDS for seed in seeds for share in SHARES.values()]
    covariance = learn_covariance(map_in_processes(residuals_of, learnt, jobs, "to learn from"))
    for row in range(len(covariance)):
        say(", ".join(f"{value:.5f}" for value in covariance[row, : row + 1]))
    return 0
