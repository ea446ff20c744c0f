# SPDX-License-Identifier: MIT
"""Query a library of procedural creatures with parts of them: without the index, without local heat, as is.

    python -m benchmarks parts [--individuals N] [--queries N] [--first N] [--rank both|shape] [--jobs N]

missing   creatures with a third, a half and two thirds cut off, re-meshed halves, and "partial" of the
          benchmark at strength 5 (30 % missing and five holes): the rank of the whole; also with a third and
          a half cut off in another pose than the whole has in the library
swollen   creatures with swollen limbs ("local scale" at strengths 3 and 5) and two openings like eyes, or
          with a twelfth cut off: local heat, which finds bent parts, must not mislead here
shared    half a creature that two shapes of the library share, each joined to another creature: how often
          both are among the first two, five and ten

Individuals are of seeds that no model was trained on. Prints tables of how many queries count as cut off, of
the mean reciprocal rank, the share that comes first and among the first five, and the processor time of a
search.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.experiments.evidence_pairs import cut, remeshed
from benchmarks.parallel import map_in_processes
from shapegoogle_core import Library, Mesh, ShapeSignature, load_model
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.library.search.settings import CandidateSettings, SearchSettings
from shapegoogle_core.model.augmentation import transform

__all__ = ["add_options", "run"]

FIRST_SEED = 4_000
CUTS = {"a third missing": 2 / 3, "half missing": 1 / 2, "two thirds missing": 1 / 3}
POSED_CUTS = ("a third missing", "half missing")
SWOLLEN = (3, 5)
# Radius of openings like eyes and the distance between them, as shares of √area.
EYE_RADIUS, EYE_DISTANCE = 0.05, 0.16
TOP = 50
Rank = Literal["both", "shape"]


def _describe(mesh: Mesh) -> ShapeSignature:
    return load_model().describe(mesh)


def whole(job: tuple[str, int]) -> ShapeSignature:
    """Describe a creature of this kind and seed."""
    kind, seed = job
    return _describe(make_creature(kind, seed).pose(0))


def _with_eyes(mesh: Mesh, random: np.random.Generator) -> Mesh:
    """Remove the faces around two places that are near each other."""
    points, unit = mesh.vertices, np.sqrt(mesh.area)
    first = np.linalg.norm(points - points[random.integers(len(points))], axis=1) / unit
    second = np.linalg.norm(points - points[np.abs(first - EYE_DISTANCE).argmin()], axis=1) / unit
    near = np.minimum(first, second) < EYE_RADIUS
    return Mesh(points, mesh.faces[~near[mesh.faces].all(axis=1)])


def parts(job: tuple[str, int]) -> dict[str, ShapeSignature]:
    """Describe the rest of a creature after each kind of cut, rotated."""
    kind, seed = job
    random = np.random.default_rng([seed, len(kind)])
    creature = make_creature(kind, seed)
    mesh, posed = creature.pose(0), creature.pose(1)
    meshes = {name: cut(mesh, random.normal(size=3), share) for name, share in CUTS.items()}
    meshes["partial, strength 5"] = transform(mesh, "partial", 5, int(random.integers(2**31)))
    meshes["half missing, another mesh"] = remeshed(meshes["half missing"], random)
    for name in POSED_CUTS:
        meshes[f"{name}, another pose"] = cut(posed, random.normal(size=3), CUTS[name])
    for strength in SWOLLEN:
        swollen = transform(mesh, "local_scale", strength, 11 + seed)
        meshes[f"swollen at strength {strength}, with eyes"] = _with_eyes(swollen, random)
        meshes[f"swollen at strength {strength}, a twelfth missing"] = cut(
            swollen, random.normal(size=3), 11 / 12
        )
    turn = Rotation.random(random_state=seed).as_matrix()
    return {name: _describe(Mesh(part.vertices @ turn.T, part.faces)) for name, part in meshes.items()}


def shared(job: tuple[str, int, tuple[str, str]]) -> tuple[ShapeSignature, list[ShapeSignature]]:
    """Describe half of a creature, and its union with each of two others, scaled to the same area."""
    kind, seed, others = job
    random = np.random.default_rng([seed, len(kind), 1])
    direction = random.normal(size=3)
    half = cut(make_creature(kind, seed).pose(0), direction, 0.5)
    grown = []
    for other in others:
        host = make_creature(other, seed + 1).pose(0)
        scale = np.sqrt(half.area / host.area)
        points = host.vertices * scale
        # Beyond the cut, and a little into it.
        beyond = direction / np.linalg.norm(direction)
        points += half.vertices.mean(axis=0) - points.mean(axis=0)
        points += beyond * ((half.vertices @ beyond).max() - (points @ beyond).min())
        points -= 0.02 * np.sqrt(half.area) * beyond
        faces = np.concatenate([half.faces, host.faces + len(half.vertices)])
        grown.append(_describe(Mesh(np.concatenate([half.vertices, points]), faces.astype(np.int32))))
    return _describe(half), grown


def places(
    library: Library, queries: Iterable[tuple[ShapeSignature, Sequence[str]]], rank: Rank
) -> tuple[np.ndarray, float]:
    """Query; return the rank of each wanted shape, infinite beyond `TOP`, and the median processor time."""
    found, seconds = [], []
    for signature, wanted in queries:
        started = time.process_time()
        names = [match.name for match in library.query(signature, top=TOP, explain=0, rank=rank)]
        seconds.append(time.process_time() - started)
        found.append([names.index(name) + 1 if name in names else np.inf for name in wanted])
    return np.array(found), float(np.median(seconds))


def _without_heat(signature: ShapeSignature) -> ShapeSignature:
    assert signature.sample is not None
    return replace(signature, sample=replace(signature.sample, packed_heat=b""))


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    for name, default, text in (
        ("--individuals", 33, "of each of 31 kinds (33: 1,023 shapes)"),
        ("--queries", 62, "creatures that are cut (62)"),
        ("--jobs", 2, "worker processes (2)"),
    ):
        parser.add_argument(name, type=number_from(1), default=default, metavar="N", help=text)
    parser.add_argument(
        "--first", type=number_from(0), default=0, metavar="N", help="creatures before those that are cut (0)"
    )
    parser.add_argument("--rank", choices=get_args(Rank), default="both", help="order of the matches (both)")


def run(options: argparse.Namespace) -> int:
    """Make the library, query it and print the tables.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    kinds = list(CREATURE_KINDS)
    jobs = [(kind, FIRST_SEED + number) for number in range(options.individuals) for kind in kinds]
    asked = jobs[options.first : options.first + options.queries]
    grafts = [
        (kind, seed + 500, (kinds[(index + 7) % len(kinds)], kinds[(index + 16) % len(kinds)]))
        for index, (kind, seed) in enumerate(asked)
    ]
    with (
        tempfile.TemporaryDirectory() as folder,
        Library.open(Path(folder) / "creatures.sglib") as library,
    ):
        signatures = map_in_processes(whole, jobs, options.jobs, "creatures")
        for (kind, seed), signature in zip(jobs, signatures, strict=True):
            library.add_signature(signature, f"{kind} {seed}")
        halves = map_in_processes(shared, grafts, options.jobs, "grafts")
        for (kind, seed, _), (_, grown) in zip(grafts, halves, strict=True):
            for number, signature in enumerate(grown):
                library.add_signature(signature, f"{kind} {seed} on {number}")
        remains = map_in_processes(parts, asked, options.jobs, "parts")
        print_tables(library, asked, remains, grafts, halves, options.rank)
    return 0


def print_tables(
    library: Library,
    asked: Sequence[tuple[str, int]],
    remains: Sequence[dict[str, ShapeSignature]],
    grafts: Sequence[tuple[str, int, tuple[str, str]]],
    halves: Sequence[tuple[ShapeSignature, list[ShapeSignature]]],
    rank: Rank,
) -> None:
    """Query without the index of parts, without local heat, and as is, and print all."""
    print(f"{len(library):,} shapes, {len(asked)} queries of each sort")
    print("Columns: without the index of parts, without local heat, with both.\n")
    without_index = SearchSettings(candidates=CandidateSettings(sharing=0))
    ways = [
        (Library.open(library.path, read_only=True, search=without_index), False),
        (library, False),
        (library, True),
    ]
    print("| | cut off |" + 3 * " MRR | first | among five | s |")
    print("|---|---|" + 3 * "---|---|---|---|")
    for sort in remains[0]:
        queries = [
            (left[sort], [f"{kind} {seed}"]) for (kind, seed), left in zip(asked, remains, strict=True)
        ]
        cells = [f"{sum(left.sample is not None and left.sample.is_cut for left, _ in queries)}"]
        for searched, heated in ways:
            asked_for = queries if heated else [(_without_heat(left), names) for left, names in queries]
            found, seconds = places(searched, asked_for, rank)
            cells += [f"{(1 / found).mean():.3f}", f"{100 * (found == 1).mean():.0f} %"]
            cells += [f"{100 * (found <= 5).mean():.0f} %", f"{seconds:.2f}"]
        print(f"| {sort} | " + " | ".join(cells) + " |")
    print("\n| half shared by two |" + 3 * " both in 2 | 5 | 10 |" + "\n|---|" + 3 * "---|---|---|")
    cells = []
    for searched, heated in ways:
        queries = [
            (half if heated else _without_heat(half), [f"{kind} {seed} on {number}" for number in range(2)])
            for (kind, seed, _), (half, _) in zip(grafts, halves, strict=True)
        ]
        found, _ = places(searched, queries, rank)
        cells += [f"{100 * (found.max(axis=1) <= top).mean():.0f} %" for top in (2, 5, 10)]
    print("| | " + " | ".join(cells) + " |")
    ways[0][0].close()
