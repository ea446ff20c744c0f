# SPDX-License-Identifier: MIT
"""Teach the shipped model how to order shapes of a kind.

    python -m benchmarks train-ranking --blend-meshes FOLDER

Weights, gate and calibration of `shapegoogle_core.model.ranking` are chosen on procedural objects and
creatures by kind, on individual creatures in several poses, and on the CC0 packs to learn from, with words
of their names as kinds. Run it again whenever views or background of the model have changed.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.kinds.sets import LEARNING_PACKS, weak_labels
from benchmarks.objects import OBJECT_KINDS, make_object
from benchmarks.parallel import map_in_processes
from benchmarks.training.background import add_options
from shapegoogle_core.library.search.traits import TraitDistances
from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.ranking import Ranking, figures_of
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["Labelled", "add_options", "learn_ranking", "run"]

_SEEDS = (4_000, 5_000)
_CREATURE_SEEDS = (5_000, 5_001)
_POSES = (0, 1, 2)
# Weights of bags and of simple measures, where all distances are divided by their standard deviation and that
# of views is 1.
_BAG_WEIGHTS = (0.3, 0.5, 0.7, 1.0)
_FIGURE_WEIGHTS = (0.0, 0.15, 0.3, 0.45, 0.6)
_AGREEMENTS, _POWERS = (0.25, 0.3, 0.4), (1.0, 2.0, 4.0)
# The same individual must be found as well as by bags alone, up to this (points of first tier).
_ALLOWED_LOSS = 0.3
_RIVALS = 5


@dataclass(frozen=True)
class Labelled:
    """A shape to learn from.

    Attributes
    ----------
    group : str
        "objects", "creatures" or "models"; kinds are compared within it.
    kind : str
    individual : str
        Shapes of one individual are the same shape.
    source : str
        Kind of the object or the creature, or the file of the model.
    seed, pose : int
    """

    group: str
    kind: str
    individual: str
    source: str
    seed: int = 0
    pose: int = 0


def _describe(model: ShapeModel, folder: Path, shape: Labelled) -> ShapeSignature:
    if shape.group == "objects":
        return model.describe(make_object(shape.source, shape.seed))
    if shape.group == "creatures":
        return model.describe(make_creature(shape.source, shape.seed).pose(shape.pose))
    return model.describe(read_mesh(folder / shape.source))


def _shapes(folder: Path) -> list[Labelled]:
    shapes = [
        Labelled("objects", kind, f"{kind} {seed}", kind, seed) for kind in OBJECT_KINDS for seed in _SEEDS
    ]
    shapes += [
        Labelled("creatures", kind, f"creature {kind} {seed}", kind, seed, pose)
        for kind in CREATURE_KINDS
        for seed in _CREATURE_SEEDS
        for pose in _POSES
    ]
    with (folder / "meshes.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] in LEARNING_PACKS]
    names = [row["shape"].removeprefix(f"{row['pack']}-") for row in rows]
    labels = weak_labels(names, [row["pack"] for row in rows])
    return shapes + [
        Labelled("models", label, row["file"], row["file"]) for row, label in zip(rows, labels, strict=True)
    ]


def learn_ranking(
    model: ShapeModel, shapes: Sequence[Labelled], signatures: Sequence[ShapeSignature]
) -> tuple[Ranking, str]:
    """Choose weights and gate by first tiers, and calibrate the likeness.

    Parameters
    ----------
    model : ShapeModel
        With views and a background.
    shapes, signatures : sequences of n
        Labels and signatures.

    Returns
    -------
    ranking : Ranking
    report : str
        What it reaches on these shapes.
    """
    rows = np.stack(
        [figures_of(signature.measures, signature.area, signature.extents) for signature in signatures]
    )
    plain = Ranking(
        view_weight=1.0,
        bag_weight=0.0,
        figure_weight=0.0,
        figure_mean=np.nanmean(rows, axis=0),
        figure_scale=np.nanstd(rows, axis=0),
        unknown_views=1.0,
        agreement=1.0,
        power=1.0,
        likeness_half=1.0,
        likeness_slope=1.0,
    )
    views, bags, figures, agreement = _matrices(model, plain, signatures)
    groups = np.array([shape.group for shape in shapes])
    kinds = np.array([f"{shape.group} {shape.kind}" for shape in shapes])
    individuals = np.array([shape.individual for shape in shapes])
    upper = np.triu_indices(len(shapes), 1)
    spread = [float(matrix[upper].std()) for matrix in (views, bags, figures)]

    def kind_quality(distances: FloatArray) -> float:
        values = [
            value
            for group in np.unique(groups)
            for value in _tiers(distances, kinds, np.flatnonzero(groups == group))
        ]
        return float(np.mean(values))

    def weighted(bag: float, figure: float) -> FloatArray:
        return views / spread[0] + bag * bags / spread[1] + figure * figures / spread[2]

    bag, figure = max(
        product(_BAG_WEIGHTS, _FIGURE_WEIGHTS), key=lambda weights: kind_quality(weighted(*weights))
    )
    weights = np.array([1 / spread[0], bag / spread[1], figure / spread[2]])
    weights /= weights.sum()
    kind = weights[0] * views + weights[1] * bags + weights[2] * figures
    ranking = replace(
        plain,
        view_weight=float(weights[0]),
        bag_weight=float(weights[1]),
        figure_weight=float(weights[2]),
        unknown_views=float(np.median(views[upper])),
    )
    posed = np.flatnonzero(groups == "creatures")
    least = _tiers(bags, individuals, posed)[1] - _ALLOWED_LOSS
    gated = []
    for width, power in product(_AGREEMENTS, _POWERS):
        tried = replace(ranking, agreement=width, power=power)
        sorting = tried.sorting_distances(kind, agreement, 1.0)
        if _tiers(sorting, individuals, posed)[1] >= least:
            gated.append((kind_quality(sorting), tried, sorting))
    quality, ranking, sorting = max(gated, key=lambda found: found[0])
    half, slope = _calibrated(kind, kinds, individuals, groups)
    ranking = replace(ranking, likeness_half=half, likeness_slope=slope)
    lines = [f"kinds {quality:.1f}, individuals {_tiers(sorting, individuals, posed)[1]:.1f} (first tier)"]
    for group in np.unique(groups):
        nearest, first = _tiers(sorting, kinds, np.flatnonzero(groups == group))
        lines.append(f"{group}: nearest neighbour {nearest:.1f}, first tier {first:.1f}")
    return ranking, "\n".join(lines)


def _matrices(
    model: ShapeModel, ranking: Ranking, signatures: Sequence[ShapeSignature]
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Distances of views, bags and figures (n, n), and distances of bags divided by the typical ones."""
    parts = []
    for view, bag, figure in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        alone = replace(ranking, view_weight=view, bag_weight=bag, figure_weight=figure)
        compared = TraitDistances(model.with_parts(ranking=alone))
        traits = compared.of(signatures)
        parts.append(
            np.stack([compared.kind_distances(traits, row, traits) for row in range(len(signatures))])
        )
    typical = np.sqrt(traits.background[:, None] * traits.background)
    return parts[0], parts[1], parts[2], parts[1] / typical


def _tiers(distances: FloatArray, labels: NDArray[np.str_], chosen: NDArray[np.intp]) -> tuple[float, float]:
    """Nearest neighbour and first tier in per cent, each chosen shape against the others."""
    nearest, tier = [], []
    for row in chosen:
        others = chosen[chosen != row]
        related = labels[others] == labels[row]
        if not related.any():
            continue
        order = np.argsort(distances[row, others], kind="stable")
        nearest.append(related[order[0]])
        tier.append(related[order[: related.sum()]].mean())
    return 100 * float(np.mean(nearest)), 100 * float(np.mean(tier))


def _calibrated(
    kind: FloatArray, kinds: NDArray[np.str_], individuals: NDArray[np.str_], groups: NDArray[np.str_]
) -> tuple[float, float]:
    """Fit the likeness on pairs of a kind and on each shape's nearest of other kinds."""
    values, same, weights = [], [], []
    for row in range(len(kind)):
        related = np.flatnonzero((kinds == kinds[row]) & (individuals != individuals[row]))
        others = np.flatnonzero(kinds != kinds[row])
        rivals = others[np.argsort(kind[row, others])[:_RIVALS]]
        if not len(related):
            continue
        # Each shape and each group counts alike, and so do pairs of one kind and of two.
        share = 1 / (groups == groups[row]).sum()
        for numbers, is_same in ((related, True), (rivals, False)):
            values += kind[row, numbers].tolist()
            same += [is_same] * len(numbers)
            weights += [share / len(numbers)] * len(numbers)
    regression = LogisticRegression(C=1e6)
    features = np.log(np.maximum(values, 1e-3))[:, None]
    regression.fit(features, same, sample_weight=np.array(weights) / np.mean(weights))
    slope = -float(regression.coef_[0, 0])
    return float(np.exp(regression.intercept_[0] / slope)), slope


def run(options: argparse.Namespace) -> int:
    """Describe the shapes, learn, and write the model again.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    model, shapes = load_model(options.model), _shapes(options.blend_meshes)
    describe = partial(_describe, model, options.blend_meshes)
    signatures = map_in_processes(describe, shapes, options.jobs, "shapes")
    ranking, report = learn_ranking(model, shapes, signatures)
    model.with_parts(ranking=ranking).save(options.model)
    print(f"{ranking}\n{report}")
    return 0
