# SPDX-License-Identifier: MIT
"""Teach the shipped model how to order shapes of a kind.

    python -m benchmarks train-ranking --blend-meshes FOLDER

Weights, gate and calibration of `shapegoogle_core.model.ranking` are chosen on the development sets of
`benchmarks.kinds`: procedural objects, as they are and as polygon soup, and creatures by kind; creatures and
people in several poses, damaged; and the CC0 packs to learn from, with words of their names as kinds. Run it
again whenever views or background of the model have changed.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression

from benchmarks.experiments.retrieval import default_cache
from benchmarks.kinds.describing import DescribedSet, describe_set
from benchmarks.kinds.sets import DEVELOPMENT, KindSet, pack_sets, procedural_sets
from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.training import background
from shapegoogle_core.cli.text import say
from shapegoogle_core.library.search.traits.distances import TraitDistances
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.ranking import Ranking, figures_of
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["Group", "add_options", "learn_ranking", "run"]

# Number of shapes of each label to learn from; of other sets all.
_OF_A_LABEL = {"objects": 3, "soup": 3, "creatures": 4}
# Sets whose labels are individuals, and other sets that these are found among.
_AMONG: dict[str, tuple[str, ...]] = {"poses": ("creatures",), "people": ()}
# Weights of bags and of simple measures, where the distances of views and measures are divided by their
# standard deviation and the weight of views is 1.
_BAG_WEIGHTS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5)
_FIGURE_WEIGHTS = (0.0, 0.15, 0.3, 0.45, 0.6)
_AGREEMENTS, _POWERS = (0.3, 0.4, 0.5, 0.6), (1.0, 1.5, 2.0, 3.0)
_DISTRUSTS = (0.0, 1.0, 2.0, 3.0)
# Chosen on halves of development shapes (docs/measurements/kinds.md).
_CERTAIN_ODDS = 5.0
_RIVALS = 5


@dataclass(frozen=True)
class Group:
    """Shapes that are compared with each other.

    Attributes
    ----------
    name : str
    labels : (n,) array of str
        Shapes with the same label should find each other.
    queries : (m,) array of int
        Numbers of the shapes that are asked for the others of their label.
    by_kind : bool
        Whether labels are kinds, or individuals.
    signatures : sequence of n ShapeSignature
    """

    name: str
    labels: NDArray[np.str_]
    queries: NDArray[np.intp]
    by_kind: bool
    signatures: Sequence[ShapeSignature]


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Distances (n, n) between the shapes of a group, and their typical distances."""

    group: Group
    views: FloatArray
    bags: FloatArray
    figures: FloatArray
    typical: FloatArray

    def kind_distances(self, ranking: Ranking) -> FloatArray:
        return ranking.kind_distances(self.bags, self.views, self.figures)

    def sorting_distances(self, ranking: Ranking) -> FloatArray:
        return ranking.sorting_distances(self.kind_distances(ranking), self.bags, self.typical)

    def tiers(self, distances: FloatArray) -> tuple[float, float]:
        """Nearest neighbour and first tier of the queries in percent."""
        nearest, tier = [], []
        for row in self.group.queries:
            related = np.delete(self.group.labels == self.group.labels[row], row)
            if related.any():
                order = np.argsort(np.delete(distances[row], row), kind="stable")
                nearest.append(related[order[0]])
                tier.append(related[order[: related.sum()]].mean())
        return 100 * float(np.mean(nearest)), 100 * float(np.mean(tier))


def _pair_distances(model: ShapeModel, ranking: Ranking, group: Group) -> _Pairs:
    compared = TraitDistances(model.with_parts(ranking=ranking))
    traits = compared.of(group.signatures)
    parts = [compared.parts(traits, row, traits) for row in range(len(group.signatures))]
    bags, typical, views, figures = (np.stack(part) for part in zip(*parts, strict=True))
    return _Pairs(group, views, bags, figures, typical)


def learn_ranking(model: ShapeModel, groups: Sequence[Group]) -> tuple[Ranking, str]:
    """Choose weights and gate by nearest neighbours and first tiers, and calibrate the likeness.

    Parameters
    ----------
    model : ShapeModel
        With views and a background.
    groups : sequence of Group
        Each counts alike.

    Returns
    -------
    ranking : Ranking
    report : str
        What it reaches on these shapes.
    """
    assert model.background is not None
    described = [each for group in groups for each in group.signatures]
    figures = figures_of(
        [each.measures for each in described],
        [each.area for each in described],
        [each.extents for each in described],
    )
    ranking = Ranking(
        view_weight=1.0,
        bag_weight=0.0,
        figure_weight=0.0,
        figure_mean=np.nanmean(figures, axis=0),
        figure_scale=np.nanstd(figures, axis=0),
        unknown_views=1.0,
        agreement=1.0,
        power=1.0,
        distinctive=model.background.distinctive,
        distrust=0.0,
        certain_odds=_CERTAIN_ODDS,
        likeness_half=1.0,
        likeness_slope=1.0,
    )
    pairs = [_pair_distances(model, ranking, group) for group in groups]
    by_kind = [each for each in pairs if each.group.by_kind]
    ranking = replace(ranking, unknown_views=float(np.median(_unlike_views(pairs))))
    spreads = np.array([_spread(pairs, part) for part in ("views", "bags", "figures")])

    def weighted(bag: float, figure: float) -> Ranking:
        weights = np.array([1, bag, figure]) / spreads
        view, bag, figure = (weights / weights.sum()).tolist()
        return replace(ranking, view_weight=view, bag_weight=bag, figure_weight=figure)

    ranking = max(
        (weighted(*tried) for tried in product(_BAG_WEIGHTS, _FIGURE_WEIGHTS)),
        key=lambda tried: np.mean([each.tiers(each.kind_distances(tried)) for each in by_kind]),
    )

    ranking = max(
        (
            replace(ranking, agreement=width, power=power, distrust=distrust)
            for width, power, distrust in product(_AGREEMENTS, _POWERS, _DISTRUSTS)
        ),
        key=lambda tried: np.mean([each.tiers(each.sorting_distances(tried)) for each in pairs]),
    )
    half, slope = _calibrated([(each.group, each.kind_distances(ranking)) for each in by_kind])
    ranking = replace(ranking, likeness_half=half, likeness_slope=slope)
    return ranking, _report(pairs, ranking)


def _spread(pairs: Sequence[_Pairs], part: str) -> float:
    """Compute the standard deviation of the distances of views, bags or simple measures."""
    distances = [getattr(each, part) for each in pairs]
    return float(np.concatenate([own[np.triu_indices(len(own), 1)] for own in distances]).std())


def _unlike_views(pairs: Sequence[_Pairs]) -> FloatArray:
    """Collect the distances of the views of different things."""
    return np.concatenate(
        [each.views[each.group.labels[:, None] != each.group.labels] for each in pairs if each.group.by_kind]
    )


def _report(pairs: Sequence[_Pairs], ranking: Ranking) -> str:
    lines = ["nearest neighbour and first tier"]
    lines.append(" " * 20 + "".join(f"{each.group.name:>21}" for each in pairs))
    orders: dict[str, Callable[[_Pairs], FloatArray]] = {
        "views": lambda each: each.views,
        "bags": lambda each: each.bags,
        "simple measures": lambda each: each.figures,
        "the three together": lambda each: each.kind_distances(ranking),
        "with the gate": lambda each: each.sorting_distances(ranking),
    }
    for name, order in orders.items():
        cells = ["{:.1f} {:.1f}".format(*each.tiers(order(each))) for each in pairs]
        lines.append(f"{name:20}" + "".join(f"{cell:>21}" for cell in cells))
    return "\n".join(lines)


def _calibrated(groups: Sequence[tuple[Group, FloatArray]]) -> tuple[float, float]:
    """Fit the likeness on pairs of a kind and on each shape's nearest of other kinds, within each group."""
    values, same, weights = [], [], []
    for group, kind in groups:
        for row, label in enumerate(group.labels):
            related = np.setdiff1d(np.flatnonzero(group.labels == label), row)
            others = np.flatnonzero(group.labels != label)
            rivals = others[np.argsort(kind[row, others])[:_RIVALS]]
            if not len(related):
                continue
            # Each shape and each group counts alike, and so do pairs of one kind and of two.
            for numbers, is_same in ((related, True), (rivals, False)):
                values += kind[row, numbers].tolist()
                same += [is_same] * len(numbers)
                weights += [1 / len(group.labels) / len(numbers)] * len(numbers)
    regression = LogisticRegression(C=1e6)
    features = np.log(np.maximum(values, 1e-3))[:, None]
    regression.fit(features, same, sample_weight=np.array(weights) / np.mean(weights))
    slope = -float(regression.coef_[0, 0])
    return float(np.exp(regression.intercept_[0] / slope)), slope


def _learning_sets(blend_meshes: Path) -> list[KindSet]:
    """Choose the development sets, the first shapes of each label."""
    sets = []
    for made in (*procedural_sets(), *pack_sets(blend_meshes)):
        most, met, shapes = _OF_A_LABEL.get(made.name), Counter[str](), []
        for shape in made.shapes:
            met[shape.label] += 1
            if most is None or met[shape.label] <= most:
                shapes.append(shape)
        if made.use == DEVELOPMENT:
            sets.append(replace(made, shapes=tuple(shapes)))
    return sets


def _groups(sets: Mapping[str, DescribedSet]) -> list[Group]:
    groups = []
    for name, found in sets.items():
        labels, signatures = [*found.labels], [*found.signatures]
        for other in _AMONG.get(name, ()):
            labels += [f"{other} {label}" for label in sets[other].labels]
            signatures += sets[other].signatures
        queries = np.arange(len(found.labels))
        groups.append(Group(name, np.array(labels), queries, name not in _AMONG, signatures))
    return groups


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    background.add_options(parser)
    parser.add_argument(
        "--cache", type=Path, metavar="FOLDER", help="signatures (default: in the user's cache folder)"
    )
    parser.add_argument(
        "--any-code",
        action="store_true",
        help="reuse signatures kept by runs with this option, even if the code has changed since",
    )


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
    model = load_model(options.model)
    cache = BenchmarkCache(options.cache or default_cache())
    sets: dict[str, DescribedSet] = {}
    for made in _learning_sets(options.blend_meshes):
        sets[made.name] = describe_set(
            made, model, options.model, cache, jobs=options.jobs, any_code=options.any_code
        )
        for name, reason in sets[made.name].failures.items():
            say(f"left out: {made.name}: {name}: {reason}")
    ranking, report = learn_ranking(model, _groups(sets))
    model.with_parts(ranking=ranking).save(options.model)
    print(f"{ranking}\n{report}")
    return 0
