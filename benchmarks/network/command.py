# SPDX-License-Identifier: MIT
"""Measure what the network in the views adds to the search for the same kind, fused with everything else.

    python -m benchmarks network --blend-meshes FOLDER [--sets NAME …] [--data FOLDER]

The shipped model's distances of views, without and with the network, are divided by their standard deviation,
and half of that of the bags is added. Printed are the scores of `python -m benchmarks kinds`, plain and after
a walk over the neighbour graph, and the gain in first tier with its 95 % interval.
"""

from __future__ import annotations

import argparse
from dataclasses import astuple
from pathlib import Path

import numpy as np

from benchmarks.errors import BenchmarkError
from benchmarks.experiments.retrieval import EVALUATION_DATA, default_cache
from benchmarks.kinds.describing import describe_set
from benchmarks.kinds.parts import bag_distances, gradient_distances, view_distances
from benchmarks.kinds.sets import evaluation_sets, pack_sets, procedural_sets
from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.metrics import category_scores
from shapegoogle_core.cli.command import DONE
from shapegoogle_core.cli.text import table
from shapegoogle_core.library.neighbours.walk import (
    link_weights,
    links_of,
    visits,
    walked_distances,
)
from shapegoogle_core.library.search.settings import WalkSettings
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import load_model

__all__ = ["add_options", "gain_in_first_tier", "run", "walked_places"]

SETS = (
    "objects",
    "creatures",
    "packs to learn from",
    "things",
    "turned things",
    "packs held out",
    "Princeton",
)
_BAGS = 0.5
_DRAWS = 2_000


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
        "--sets", nargs="+", choices=SETS, default=SETS, metavar="NAME", help=f"some of {', '.join(SETS)}"
    )
    parser.add_argument(
        "--data", type=Path, default=EVALUATION_DATA, metavar="FOLDER", help="evaluation data (%(default)s)"
    )
    parser.add_argument(
        "--cache", type=Path, metavar="FOLDER", help="signatures (default: in the user's cache folder)"
    )
    parser.add_argument(
        "--any-code",
        action="store_true",
        help="reuse signatures kept by runs with this option, even if the code has changed since",
    )


def run(options: argparse.Namespace) -> int:
    """Measure, and print a table and the gains.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    sets = [*procedural_sets(), *pack_sets(options.blend_meshes), *evaluation_sets(options.data)]
    model, cache = load_model(), BenchmarkCache(options.cache or default_cache())
    rows: list[tuple[str, ...]] = [("set", "queries", "distance", "NN", "FT", "ST", "DCG")]
    gains = []
    for chosen in (made for made in sets if made.name in options.sets):
        described = describe_set(chosen, model, "default", cache, any_code=options.any_code)
        gradients, views = gradient_distances(described, model), view_distances(described, model)
        if gradients is None or views is None:
            raise BenchmarkError("the shipped model has no network; learn it with `train-views`")
        bags = _BAGS * _scaled(bag_distances(described, model))
        base, fused = _scaled(gradients) + bags, _scaled(views) + bags
        versions = {
            "without": base,
            "with": fused,
            "without, walked": walked_places(base),
            "with, walked": walked_places(fused),
        }
        for name, distances in versions.items():
            scores = astuple(category_scores(distances, described.labels))
            percent = [f"{100 * score:.1f}" for score in scores]
            rows.append((chosen.name, str(chosen.query_count), name, *percent))
        for name in ("", ", walked"):
            before, after = versions[f"without{name}"], versions[f"with{name}"]
            mean, low, high = gain_in_first_tier(before, after, described.labels)
            gains.append(f"{chosen.name}{name}: first tier {mean:+.1f} [{low:+.1f}, {high:+.1f}]")
    print("\n".join([*table(rows, "<><>>>>"), *gains]))
    return DONE


def walked_places(distances: FloatArray, settings: WalkSettings | None = None) -> FloatArray:
    """Order every row by the product's walk over the graph of the whole set.

    Parameters
    ----------
    distances : (n, n) array
        Symmetric.
    settings : WalkSettings, optional

    Returns
    -------
    places : (n, n) array
        Place of each shape in the list of each query.
    """
    settings = settings or WalkSettings()
    count = len(distances)
    others = [np.delete(np.arange(count), row) for row in range(count)]
    ends = [rest[links_of(distances[row, rest], settings)] for row, rest in enumerate(others)]
    starts = np.repeat(np.arange(count), [len(chosen) for chosen in ends])
    joined = np.concatenate(ends)
    weights = link_weights(starts, joined, distances[starts, joined], count)
    places = np.zeros((count, count))
    for row, rest in enumerate(others):
        ordered = rest[np.argsort(distances[row, rest], kind="stable")]
        visited = visits(weights, row, settings.damping)[ordered]
        walked = walked_distances(distances[row, ordered], visited, settings)
        places[row, ordered[np.argsort(walked, kind="stable")]] = np.arange(1, count)
    return places


def gain_in_first_tier(before: FloatArray, after: FloatArray, labels: list[str]) -> tuple[float, ...]:
    """Compute the gain in first tier, in percent, with its 95 % bootstrap interval over queries.

    Parameters
    ----------
    before, after : (n, n) array
        Distances.
    labels : list of n str

    Returns
    -------
    mean, low, high : float
    """
    differences = 100 * (_first_tiers(after, labels) - _first_tiers(before, labels))
    draws = np.random.default_rng(0).integers(0, len(differences), (_DRAWS, len(differences)))
    low, high = np.percentile(differences[draws].mean(axis=1), [2.5, 97.5])
    return float(differences.mean()), float(low), float(high)


def _first_tiers(distances: FloatArray, labels: list[str]) -> FloatArray:
    """First tier of each query that has companions."""
    names = np.asarray(labels)
    tiers = []
    for row, own in enumerate(names):
        rest = np.delete(np.arange(len(names)), row)
        relevant = names[rest] == own
        if count := int(relevant.sum()):
            tiers.append(relevant[np.argsort(distances[row, rest], kind="stable")[:count]].mean())
    return np.array(tiers)


def _scaled(distances: FloatArray) -> FloatArray:
    apart = distances[~np.eye(len(distances), dtype=bool)]
    return np.asarray(distances / apart.std())
