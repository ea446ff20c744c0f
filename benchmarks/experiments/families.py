# SPDX-License-Identifier: MIT
"""Measure the families of a search: which pairs of shapes are one family, and what finding them costs.

    python -m benchmarks families [--individuals N] [--poses N] [--shapes N] [--family N]

First, pairs of creatures and of plain solids. Poses of a creature and finer meshes of a solid are one family;
individuals and solids are different. Printed is the share of pairs of each that count as one family, for
several limits of the spectral difference, among all pairs whose bags are near.

Then a library of synthetic shapes, some of which are versions of one: the time of a search for this one with
and without families, as a ratio within the run, and the number of families and versions found.

Finally, a shape with one placement and the same with 1,400: times to store it, and to search and explain it.

Prints one line of JSON.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh

import shapegoogle_core as sg
from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.experiments.duplicates import DECAY, creature_samples, made_up_bags
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.library.placement import placements_of
from shapegoogle_core.library.search.query import Query
from shapegoogle_core.library.search.settings import FamilySettings
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.registration import spectral_difference

__all__ = ["add_options", "run"]

LIMITS = (0.03, 0.04, FamilySettings.max_spectral_difference, 0.06, 0.1)
REPEATS = 7
# Deviation of a version's bags from the original's, as a share of them.
DEVIATION = 0.02
PLACEMENTS = (1, 1_400)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of this experiment.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("--individuals", type=number_from(1), default=2, help="of each kind (%(default)s)")
    parser.add_argument("--poses", type=number_from(2), default=3, help="of each individual (%(default)s)")
    parser.add_argument("--shapes", type=number_from(10), default=2_000, help="of the library (%(default)s)")
    parser.add_argument("--family", type=number_from(1), default=402, help="of them versions (%(default)s)")


def run(options: argparse.Namespace) -> int:
    """Run both parts.

    Parameters
    ----------
    options : argparse.Namespace

    Returns
    -------
    exit_code : int
    """
    model = sg.load_model()
    pairs = _near_pairs(model, options.individuals, options.poses)
    search = _search(model, options.shapes, options.family)
    placements = {str(count): _placed(model, count) for count in PLACEMENTS}
    print(json.dumps({"pairs": pairs, "search": search, "placements": placements}))
    return 0


def _solids() -> dict[str, sg.Mesh]:
    make = trimesh.creation
    solids = {
        "cube": make.box(),
        "brick": make.box((1, 1, 1.2)),
        "long brick": make.box((1, 2, 3)),
        "plate": make.box((10, 10, 1)),
        "ball": make.icosphere(3),
        "cylinder": make.cylinder(1, 2),
        "rod": make.cylinder(1, 4),
        "cone": make.cone(1, 2),
        "capsule": make.capsule(),
        "torus": make.torus(1, 0.3),
        "pipe": make.annulus(0.5, 1, 1),
    }
    return {name: sg.Mesh(solid.vertices, solid.faces, name) for name, solid in solids.items()}


def _near_pairs(model: sg.ShapeModel, individuals: int, poses: int) -> dict[str, object]:
    """Count the pairs whose bags are near, and those of them within each limit."""
    shapes: list[tuple[str, sg.ShapeSignature]] = []
    for name, solid in _solids().items():
        finer = trimesh.Trimesh(solid.vertices, solid.faces, process=False).subdivide()
        shapes += [(name, model.describe(mesh)) for mesh in (solid, (finer.vertices, finer.faces))]
    for kind in CREATURE_KINDS:
        for seed in range(individuals):
            creature = make_creature(kind, seed, 2_000)
            shapes += [(creature.rest.name, model.describe(creature.pose(pose))) for pose in range(poses)]
    vectors = model.comparable(np.stack([signature.bags for _, signature in shapes]))
    differences: dict[bool, list[float]] = {True: [], False: []}
    for number, (name, signature) in enumerate(shapes):
        similar = model.similarity(Query(model, [signature]).distances(vectors[:number]))
        for other in np.flatnonzero(similar >= FamilySettings.min_similarity):
            one, two = signature.sample, shapes[other][1].sample
            if one is not None and two is not None:
                differences[name == shapes[other][0]].append(spectral_difference(one, two))
    return {
        name: {
            "near": len(differences[same]),
            "one family": {
                str(limit): round(float(np.mean(np.array(differences[same]) <= limit)), 3) for limit in LIMITS
            },
        }
        for name, same in (("the same", True), ("different", False))
        if differences[same]
    }


def _search(model: sg.ShapeModel, count: int, family: int) -> dict[str, object]:
    """Search a library for a shape that has many versions in it."""
    random = np.random.default_rng(0)
    inverse = np.linalg.pinv(model.projection.astype(np.float64))
    spread = 1 / (1 + np.arange(len(inverse)) / DECAY)
    vectors = random.standard_normal((count, len(inverse))) * spread
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    samples = creature_samples()
    signature = model.describe(make_creature("human", 0).rest)
    original = np.asarray(signature.bags, np.float32)
    with tempfile.TemporaryDirectory() as folder, sg.Library.open(Path(folder, "shapes.sglib")) as library:
        shapes = []
        for number, vector in enumerate(vectors):
            if number < family:
                bags = original * (1 + DEVIATION * random.standard_normal(original.shape)).astype(np.float32)
                sample = signature.sample
            else:
                bags = made_up_bags(model, 2 * vector[None], inverse)[0]
                sample = samples[number % len(samples)]
            code = model.codes(bags[None])[0]
            described = replace(signature, bags=bags, code=code, sample=sample)
            shapes.append(NewShape(described, f"shape {number}"))
        library.replace_source("shapes", size=None, mtime_ns=None, sha256=None, shapes=shapes)
        times: dict[bool, list[float]] = {False: [], True: []}
        for _ in range(REPEATS):
            for families in times:
                started = time.process_time()
                found = library.query(signature, top=50, explain=0, families=families)
                times[families].append(time.process_time() - started)
        return {
            "shapes": count,
            "milliseconds": {str(families): _middle(own) for families, own in times.items()},
            "ratio": round(_middle(times[True]) / _middle(times[False]), 2),
            "families": len(found),
            "versions": found[0].versions,
        }


def _placed(model: sg.ShapeModel, count: int) -> dict[str, float]:
    """Store a shape with this number of placements, and find it."""
    random = np.random.default_rng(0)
    mesh = make_creature("ape", 0).rest
    objects = []
    for number in range(count):
        matrix = np.eye(4)
        matrix[:3, 3] = random.uniform(-50, 50, 3) if number else 0
        objects.append((f"Ape.{number:04d}", matrix))
    signature = model.describe(mesh, keep_surface=True)
    shape = NewShape(signature, "Ape.0000", "Ape.0000", placements=placements_of(mesh, objects))
    with tempfile.TemporaryDirectory() as folder, sg.Library.open(Path(folder, "shapes.sglib")) as library:
        empty = library.path.stat().st_size
        started = time.process_time()
        library.replace_source("apes.blend", size=None, mtime_ns=None, sha256=None, shapes=[shape])
        stored = time.process_time() - started
        times = []
        for _ in range(REPEATS):
            started = time.process_time()
            library.query(signature)
            times.append(time.process_time() - started)
        return {
            "store": _middle([stored]),
            "search and explain": _middle(times),
            "bytes": library.path.stat().st_size - empty,
        }


def _middle(seconds: Sequence[float]) -> float:
    return round(1e3 * statistics.median(seconds), 1)
