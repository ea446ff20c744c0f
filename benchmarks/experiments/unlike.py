# SPDX-License-Identifier: MIT
"""Measure how often different assets are taken for the same shape, and whether the same shape still is.

    python -m benchmarks unlike --blend-meshes FOLDER [--queries N] [--creatures N] [--top N] [--as-before]

CC0 models exported by `python -m benchmarks blend-meshes` (without the posed characters) are compared with
all of them and with procedural creatures. Different assets should not be called re-posed, nor have a
similarity above 0.9. They are counted among all pairs and among the nearest of each query, and apart from
models of one series, whose names begin with the same word: a bottle full and half full, a woman in other
clothes. Then creatures are searched for in another pose: they should keep their similarity and their place.
With --as-before neither the model's background is used nor the rule about eigenfunctions of loose parts.
Prints the tables of docs/measurements/evidence.md.
"""

from __future__ import annotations

import argparse
import csv
import re
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.kinds.sets import LEARNING_PACKS
from benchmarks.parallel import map_in_processes
from shapegoogle_core import Library, Match, SearchSettings, ShapeModel, ShapeSignature, load_model
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.mesh import read_mesh

__all__ = ["add_options", "run"]

# Seeds of creatures that nothing was trained, calibrated or chosen on.
_SEEDS = (6_000, 6_001)
_SURE = 0.9
# What is a copy is one.
_SAME_SURFACE = ("identical", "moved", "scaled", "mirrored", "re-meshed")


@dataclass(frozen=True)
class _Asset:
    """A model, or a creature in a pose.

    Attributes
    ----------
    group : str
        Pack, or "creatures".
    name : str
    seed, pose : int
        Of a creature.
    """

    group: str
    name: str
    seed: int = 0
    pose: int = 0


def _describe(model: ShapeModel, folder: Path, asset: _Asset) -> ShapeSignature:
    if asset.group == "creatures":
        mesh = make_creature(asset.name, asset.seed).pose(asset.pose)
    else:
        mesh = read_mesh(folder / asset.name)
    return model.describe(mesh, keep_surface=True)


def _models(folder: Path) -> list[_Asset]:
    with (folder / "meshes.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] != "posed_characters"]
    return [_Asset(row["pack"], row["file"]) for row in rows]


def _print_different(title: str, found: Sequence[tuple[str, Match]], shown: int) -> None:
    """Print how many matches of different models claim too much, and which."""
    claims = [
        (name, match)
        for name, match in found
        if match.similarity > _SURE or (match.evidence is not None and match.evidence.kind == "re-posed")
    ]
    posed = sum(match.evidence is not None and match.evidence.kind == "re-posed" for _, match in claims)
    sure = sum(match.similarity > _SURE for _, match in claims)
    count = max(1, len(found))
    print(f"| {title} | {len(found)} | {100 * posed / count:.1f} % | {100 * sure / count:.1f} % |")
    for name, match in sorted(claims, key=lambda claim: -claim[1].similarity)[:shown]:
        kind = "" if match.evidence is None else match.evidence.kind
        print(f"    {name} finds {match.name}: {match.similarity:.3f} {kind}")


def _series(name: str) -> str:
    """Return the first word of a model's name: "Potion" of "potions-Potion2HalfFull.ply"."""
    words = re.findall(r"[A-Z]?[a-z]+", name.rpartition("-")[2].removeprefix("Smooth_"))
    return words[0].lower() if words else name


def _compare(
    library: Library, queries: Sequence[tuple[_Asset, ShapeSignature]]
) -> list[tuple[_Asset, list[Match]]]:
    """Compare each model with all shapes; leave out itself and copies of it."""
    found = []
    count = len(list(library.shapes()))
    for number, (asset, signature) in enumerate(queries, 1):
        matches = library.query(signature, top=count, explain=0)
        matches = library.explain([signature], matches, len(matches))
        others = [
            match
            for match in matches
            if match.name != asset.name
            and (match.evidence is None or match.evidence.kind not in _SAME_SURFACE)
        ]
        found.append((asset, others))
        print(f"models: {number} of {len(queries)}", file=sys.stderr)
    return found


def _print_models(found: Sequence[tuple[_Asset, list[Match]]], top: int, shown: int) -> None:
    """Print the table of different models."""
    print("\n| different shapes | pairs | re-posed | similarity above 0.9 |\n|---|---|---|---|")
    for title, learnt in (("packs to learn from", True), ("packs held out", False)):
        chosen = [
            (asset.name, match, rank, _series(asset.name) == _series(match.name))
            for asset, matches in found
            if (asset.group in LEARNING_PACKS) == learnt
            for rank, match in enumerate(matches)
        ]
        others = [pair for pair in chosen if not pair[3]]
        _print_different(f"{title}, all pairs", [pair[:2] for pair in others], shown)
        nearest = [pair[:2] for pair in others if pair[2] < top]
        _print_different(f"{title}, among the best {top}", nearest, 0)
        _print_different(f"{title}, of one series", [pair[:2] for pair in chosen if pair[3]], 0)


def _spread(items: Sequence[_Asset], count: int) -> list[_Asset]:
    """Choose some items, evenly spread over all of them."""
    chosen = np.linspace(0, len(items) - 1, min(count, len(items))).round().astype(int)
    return [items[place] for place in chosen.tolist()]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("--blend-meshes", type=Path, required=True, metavar="FOLDER", help="exported models")
    parser.add_argument("--top", type=number_from(1), default=5, metavar="N", help="best matches (5)")
    parser.add_argument(
        "--queries", type=number_from(1), default=40, metavar="N", help="models that are compared (40)"
    )
    parser.add_argument(
        "--creatures", type=number_from(1), default=16, metavar="N", help="kinds of creatures (16)"
    )
    parser.add_argument("--shown", type=number_from(0), default=0, metavar="N", help="claims listed (0)")
    parser.add_argument("--as-before", action="store_true", help="ignore how plain shapes are")
    parser.add_argument("--jobs", type=number_from(1), default=2, metavar="N", help="worker processes (2)")


def run(options: argparse.Namespace) -> int:
    """Search and print the tables.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    model, settings = load_model(), SearchSettings()
    if options.as_before:
        model = replace(model, background=None)
        settings = replace(settings, evidence=replace(settings.evidence, fewest_modes=0))
    models = _models(options.blend_meshes)
    kinds = _spread([_Asset("creatures", kind) for kind in CREATURE_KINDS], options.creatures)
    nulls = [replace(kind, seed=seed) for kind in kinds for seed in _SEEDS]
    poses = [replace(asset, pose=pose) for asset in nulls[:: len(_SEEDS)] for pose in (1, 2)]
    assets = [*models, *nulls, *poses]
    describe = partial(_describe, model, options.blend_meshes)
    described = dict(zip(assets, map_in_processes(describe, assets, options.jobs, "shapes"), strict=True))
    with (
        tempfile.TemporaryDirectory() as folder,
        Library.open(Path(folder) / "l.sglib", model, search=settings) as library,
    ):
        for asset in (*models, *nulls):
            name = f"{asset.name} {asset.seed}" if asset.group == "creatures" else asset.name
            library.add_signature(described[asset], name)
        queries = _spread(models, options.queries)
        found = _compare(library, [(asset, described[asset]) for asset in queries])
        _print_models(found, options.top, options.shown)
        sure = first = posed = 0
        for asset in poses:
            best = library.query(described[asset], top=1, explain=1)[0]
            right = best.name == f"{asset.name} {asset.seed}"
            first += right
            sure += right and best.similarity > _SURE
            posed += right and best.evidence is not None and best.evidence.kind == "re-posed"
    print("\n| creatures in another pose | first | similarity above 0.9 | re-posed |\n|---|---|---|---|")
    shares = " | ".join(f"{100 * count / len(poses):.1f} %" for count in (first, sure, posed))
    print(f"| {len(poses)} | {shares} |")
    return 0
