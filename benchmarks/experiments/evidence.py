# SPDX-License-Identifier: MIT
"""Measure how often the evidence of a match is right, on generated pairs of known kinds.

    python -m benchmarks evidence [--individuals N] [--samples | --calibrate | --similarity | --parts]

Prints the tables of docs/measurements/evidence.md: the confusion matrix, the errors of factors and shares,
and the seconds for a pair. The creatures have seeds that no model was trained on. With --calibrate, other
creatures are made and the weights of the probability of another pose are fitted, as they stand in
`shapegoogle_core/library/search/settings.py`. With --similarity, a library of four individuals of each of 31
kinds of creatures is queried with damaged and re-posed versions of one of them, and the share of right first
matches is printed by their similarity. With --parts, the pairs are flat-sided parts in families of slightly
different sizes, and the search for duplicates is measured on them too; see `evidence_parts`.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from sklearn.linear_model import LogisticRegression

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.experiments.evidence_pairs import make_pairs
from benchmarks.experiments.evidence_parts import SAME_SURFACE, print_parts
from benchmarks.parallel import map_in_processes
from shapegoogle_core import Evidence, Library, ShapeSignature, load_model
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.library.evidence import KINDS
from shapegoogle_core.library.search.evidence.kinds import Compared, Explainer, pose_features
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, transform
from shapegoogle_core.registration import SurfaceSample
from shapegoogle_core.registration.isometry import functional_map

__all__ = ["add_options", "run"]

TEST_SEED, CALIBRATION_SEED = 2_000, 3_000
LIKELY = 0.9


class Outcome(NamedTuple):
    """Evidence of a pair, and the truth.

    Attributes
    ----------
    kind, detail : str
        Of the pair.
    said : Evidence
    factor, share : float
        True values.
    pose : (float, float, float)
        Features of the probability of another pose, see `pose_features`.
    seconds : float
        Processor time for the evidence.
    similarity : float
        By the bags alone.
    """

    kind: str
    detail: str
    said: Evidence
    factor: float
    share: float
    pose: tuple[float, float, float]
    seconds: float
    similarity: float


def measure(job: tuple[str, int], exact: bool = True) -> list[Outcome]:
    """Explain all pairs of one creature, each as if it were a match of a search.

    Parameters
    ----------
    job : (str, int)
        Kind and seed of the creature.
    exact : bool
        Whether the query's whole surface is known and not only its sample.

    Returns
    -------
    outcomes : list of Outcome
    """
    model = replace(load_model(), views=None)  # no evidence rests on pictures
    outcomes = []
    pairs = make_pairs(*job)
    meshes = {id(mesh): mesh for pair in pairs for mesh in (pair.query, pair.candidate)}
    signatures = {key: model.describe(mesh, keep_surface=True) for key, mesh in meshes.items()}
    for pair in pairs:
        query, found = signatures[id(pair.query)], signatures[id(pair.candidate)]
        distances = model.distances(query.bags, found.bags[None])
        assert query.sample is not None
        assert found.sample is not None
        stored = SurfaceSample.from_bytes(found.sample.to_bytes())
        compared = Compared(stored, found, found.measures)
        asked = Compared(query.sample, query, query.measures)
        typical = model.typical_distances(query.bags, found.bags[None])
        similarity = float(model.similarity(distances, typical)[0])
        distance = float(distances[0])
        started = time.process_time()
        explainer = Explainer(asked, query.surface if exact else None)
        said = explainer.explain(compared, distance)
        seconds = time.process_time() - started
        isometry = functional_map(query.sample, stored)
        pose = isometry.spectral_difference, isometry.orthogonality, distance
        truth = pair.kind, pair.detail
        outcomes.append(Outcome(*truth, said, pair.factor, pair.share, pose, seconds, similarity))
    return outcomes


def print_tables(outcomes: Sequence[Outcome]) -> None:
    """Print the confusion matrix, the precision of claims, and the errors of factors and shares."""
    counts = Counter((outcome.kind, outcome.said.kind) for outcome in outcomes)
    print(f"{len(outcomes)} pairs; rows: the truth, columns: the evidence\n")
    print("| | " + " | ".join(KINDS) + " | right |")
    print("|---|" + "---|" * (len(KINDS) + 1))
    for kind in KINDS:
        row = [counts[kind, column] for column in KINDS]
        if not any(row):  # no pair is of this kind
            continue
        right = 100 * counts[kind, kind] / sum(row)
        print(f"| {kind} | " + " | ".join(str(count or "") for count in row) + f" | {right:.1f} % |")
    right = sum(count for (kind, said), count in counts.items() if kind == said)
    print(f"\nright: {100 * right / len(outcomes):.1f} %")
    claims = [outcome.kind == outcome.said.kind for outcome in outcomes if outcome.said.kind in SAME_SURFACE]
    precision = 100 * sum(claims) / max(1, len(claims))
    print(f"precision of the kinds of same surfaces: {precision:.1f} % of {len(claims)}")
    details: defaultdict[tuple[str, str], list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        details[outcome.kind, outcome.detail].append(outcome)
    for (true_kind, detail), found in details.items():
        hits = sum(outcome.said.kind == true_kind for outcome in found)
        likely = sum(outcome.similarity > LIKELY for outcome in found)
        print(f"  {true_kind}: {detail}: {hits} of {len(found)}; {likely} of similarity above {LIKELY}")
    for figure in ("factor", "share"):
        errors = [
            abs(getattr(outcome.said, figure) / getattr(outcome, figure) - 1)
            for outcome in outcomes
            if outcome.said.kind == outcome.kind
            and getattr(outcome.said, figure) is not None
            and outcome.kind != "similar"
        ]
        if errors:
            shown = np.quantile(errors, [0.5, 0.95])
            print(f"relative error of the {figure}: median {shown[0]:.2g}, 95 % below {shown[1]:.2g}")
    seconds = np.quantile([outcome.seconds for outcome in outcomes], [0.5, 0.95])
    print(f"processor seconds for a pair: median {seconds[0]:.3f}, 95 % below {seconds[1]:.3f}")


def print_weights(outcomes: Sequence[Outcome]) -> None:
    """Fit and print the weights of the probability of another pose."""
    chosen = [outcome for outcome in outcomes if outcome.kind in ("re-posed", "similar")]
    features = np.array([pose_features(*outcome.pose) for outcome in chosen])
    posed = np.array([outcome.kind == "re-posed" for outcome in chosen])
    regression = LogisticRegression(C=1.0, class_weight="balanced").fit(features, posed)
    print("weights", regression.coef_[0].round(2).tolist(), "offset", regression.intercept_.round(2).tolist())
    print(f"right on these {len(chosen)} pairs: {100 * regression.score(features, posed):.1f} %")


def describe(job: tuple[str, int]) -> tuple[list[tuple[str, ShapeSignature]], list[ShapeSignature]]:
    """Describe four individuals, and versions of the first: two of each transformation.

    Parameters
    ----------
    job : (str, int)
        Kind and seed of the first individual.

    Returns
    -------
    shapes : list of (name, signature)
    versions : list of ShapeSignature
    """
    kind, seed = job
    model, random = load_model(), np.random.default_rng([seed, len(kind)])
    creatures = [make_creature(kind, seed + number) for number in range(4)]
    shapes = [
        (f"{kind} {number}", model.describe(creature.pose(0))) for number, creature in enumerate(creatures)
    ]
    asked = [creatures[0].pose(pose) for pose in (1, 2)]
    for name in TRANSFORMATIONS:
        for strength in random.integers(1, 6, 2):
            asked.append(transform(creatures[0].pose(0), name, int(strength), int(random.integers(2**31))))
    return shapes, [model.describe(mesh) for mesh in asked]


def print_similarities(kinds: Sequence[str], jobs: int) -> None:
    """Print the share of right first matches, by their similarity."""
    found = []
    described = map_in_processes(describe, [(kind, TEST_SEED) for kind in kinds], jobs, "creatures")
    with (
        tempfile.TemporaryDirectory() as folder,
        Library.open(Path(folder) / "creatures.sglib") as library,
    ):
        for shapes, _ in described:
            for name, signature in shapes:
                library.add_signature(signature, name)
        for shapes, asked in described:
            for signature in asked:
                (match,) = library.query(signature, top=1, explain=1)
                found.append((match.similarity, match.name == shapes[0][0]))
    similarity, right = np.array(found).T
    print(f"{len(found)} queries\n\n| similarity of the first match | queries | right |\n|---|---|---|")
    edges = [0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0000001]
    for low, high in pairwise(edges):
        chosen = (similarity >= low) & (similarity < high)
        share = f"{100 * right[chosen].mean():.1f} %" if chosen.any() else ""
        print(f"| {low:g} to {min(high, 1):g} | {chosen.sum()} | {share} |")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--individuals",
        type=number_from(1),
        default=2,
        metavar="N",
        help="of each of 31 kinds, 16 pairs each (%(default)s)",
    )
    parser.add_argument("--calibrate", action="store_true", help="fit the probability of another pose")
    parser.add_argument(
        "--samples", action="store_true", help="use a sample of the query's surface only, as for duplicates"
    )
    parser.add_argument(
        "--jobs", type=number_from(1), default=2, metavar="N", help="worker processes (%(default)s)"
    )
    parser.add_argument("--parts", action="store_true", help="measure flat-sided parts instead of creatures")
    parser.add_argument(
        "--similarity", action="store_true", help="measure how often a first match of a similarity is right"
    )


def run(options: argparse.Namespace) -> int:
    """Measure evidence, similarity, or the weights of the evidence, and print tables.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    if options.parts:
        print_parts(options.jobs)
        return 0
    if options.similarity:
        print_similarities(CREATURE_KINDS, options.jobs)
        return 0
    first = CALIBRATION_SEED if options.calibrate else TEST_SEED
    jobs = [(kind, first + number) for kind in CREATURE_KINDS for number in range(options.individuals)]
    results = map_in_processes(partial(measure, exact=not options.samples), jobs, options.jobs, "creatures")
    outcomes = [outcome for result in results for outcome in result]
    if options.calibrate:
        print_weights(outcomes)
    else:
        print_tables(outcomes)
    return 0
