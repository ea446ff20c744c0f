# SPDX-License-Identifier: MIT
"""Measure the repeatability of keypoint detectors under the benchmark's transformations.

    python -m benchmarks keypoints [--seeds N…] [--kinds NAME…] [--strengths N…] [--json FILE]
    python -m benchmarks keypoints --data FOLDER [--json FILE]

Null shapes are procedural creatures of seeds that nothing was learnt from, or, with --data, the null shapes
of the retrieval benchmark (the lowest pose of each class of TOSCA). Each is transformed in every way and
strength. Creatures are also posed with the same vertices ("isometry"; the poses of TOSCA have no common
vertices). Keypoints are detected on the meshes as a model prepares them: preprocessed, or as in the paper.

A point is repeated if a keypoint of the null shape lies within 3 % of its diameter of the point's origin,
both measured along the null shape. The table also has the number of points, and the repeatability that
random points would reach: the share of the null shape's area within that distance of its keypoints.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.creatures import make_creature
from benchmarks.experiments.keypoint_repeatability import (
    NullShape,
    found_points,
    places_on_null,
    repeatability,
)
from benchmarks.parallel import map_in_processes
from benchmarks.protocol.collection import ISOMETRY, NULL
from benchmarks.protocol.evaluation_data import null_and_negative_shapes, read_labels
from shapegoogle_core import Mesh, MeshError, read_mesh
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.model import PRESETS
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, transform
from shapegoogle_core.preprocessing import repair

__all__ = ["Null", "add_options", "measure", "run", "summary", "table"]

KINDS = ("human", "horse", "bird", "lizard", "octopus", "fish", "hand", "desk lamp")
SEEDS = (120,)
STRENGTHS = (1, 3, 5)
VERTICES = 4000


@dataclass(frozen=True)
class Null:
    """Source of a null shape: a creature or a file.

    Attributes
    ----------
    name : str
        Kind of the creature, or name of the shape.
    seed : int
        Of the creature and of the transformations.
    path : Path or None
    """

    name: str
    seed: int = 0
    path: Path | None = None

    def versions(self, strengths: Sequence[int]) -> Iterator[tuple[str, int, Mesh]]:
        """Make the null shape, of strength 0, and all its transformed versions."""
        if self.path is None:
            creature = make_creature(self.name, self.seed, VERTICES)
            mesh = creature.pose(0)
            yield NULL, 0, mesh
            for strength in strengths:
                yield ISOMETRY, strength, creature.pose(strength)
        else:
            mesh = repair(read_mesh(self.path))
            yield NULL, 0, mesh
        for kind in TRANSFORMATIONS:
            for strength in strengths:
                try:
                    yield kind, strength, transform(mesh, kind, strength, self.seed)
                except MeshError as error:
                    print(f"left out: {error}", file=sys.stderr)


def measure(options: argparse.Namespace, null: Null) -> list[dict[str, Any]]:
    """Detect the keypoints of a shape and all its versions.

    Parameters
    ----------
    options : argparse.Namespace
        With "strengths" and "preparation".
    null : Null

    Returns
    -------
    rows : list of dict
        One for each version and detector.
    """
    settings = PRESETS["default" if options.preparation == "preprocessed" else "paper"]
    rows = []
    try:
        versions = null.versions(options.strengths)
        _, _, mesh = next(versions)
        shape, known = NullShape(mesh), found_points(settings, mesh)
        for kind, strength, version in versions:
            for detector, points in found_points(settings, version).items():
                places = places_on_null(mesh, version, kind, strength, points)
                measured = repeatability(shape, known[detector], places)
                row = {"null": null.name, "seed": null.seed, "class": kind, "strength": strength}
                null_points = len(known[detector])
                rows.append({**row, "detector": detector, "null_points": null_points, **asdict(measured)})
    except MeshError as error:
        print(f"left out: {error}", file=sys.stderr)
    return rows


def null_shapes(options: argparse.Namespace) -> list[Null]:
    """List the null shapes that the options ask for."""
    if options.data is None:
        return [Null(kind, seed) for kind in options.kinds for seed in options.seeds]
    nulls, _ = null_and_negative_shapes(read_labels(options.data))
    return [Null(shape.name, options.seeds[0], shape.path) for shape in nulls]


def summary(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Average over null shapes for each detector, class and strength; then over strengths and classes.

    Parameters
    ----------
    rows : list of dict
        From `measure`.

    Returns
    -------
    figures : list of dict
    """
    wanted = [(row["detector"], row["class"], row["strength"]) for row in rows]
    wanted += [(detector, kind, "all") for detector, kind, _ in wanted]
    wanted += [(detector, "average", "all") for detector, _, _ in wanted]
    figures = []
    for detector, kind, strength in dict.fromkeys(wanted):
        chosen = [
            row
            for row in rows
            if row["detector"] == detector
            and kind in ("average", row["class"])
            and strength in ("all", row["strength"])
        ]
        figure = {"detector": detector, "class": kind, "strength": strength}
        for name in ("points", "repeated", "chance"):
            # NaN: a version without points has no repeatability.
            figure[name] = float(np.nanmean([row[name] for row in chosen]))
        figure["without_points"] = sum(row["points"] == 0 for row in chosen)
        figures.append(figure)
    return figures


def table(figures: list[dict[str, Any]]) -> str:
    """Format the share of repeated points in %: lines are classes, columns are detectors and strengths.

    Parameters
    ----------
    figures : list of dict
        From `summary`.

    Returns
    -------
    table : str
    """
    detectors = list(dict.fromkeys(figure["detector"] for figure in figures))
    classes = list(dict.fromkeys(figure["class"] for figure in figures))
    strengths = list(dict.fromkeys(figure["strength"] for figure in figures if figure["strength"] != "all"))
    found = {(figure["detector"], figure["class"], figure["strength"]): figure for figure in figures}

    def shares(detector: str, kind: str) -> str:
        cells = [found.get((detector, kind, strength)) for strength in (*strengths, "all")]
        return " ".join("  –" if cell is None else f"{100 * cell['repeated']:3.0f}" for cell in cells)

    width = 4 * len(strengths) + 3
    heads = " | ".join(name.rjust(width) for name in detectors)
    lines = [f"repeated, %; strengths {', '.join(map(str, strengths))}, all", f"{'':12} | {heads}"]
    lines += [
        f"{kind:12} | {' | '.join(shares(name, kind).rjust(width) for name in detectors)}" for kind in classes
    ]
    for name, factor in (("points", 1), ("chance", 100)):
        cells = [f"{factor * found[detector, 'average', 'all'][name]:.1f}" for detector in detectors]
        lines.append(f"{name:12} | {' | '.join(cell.rjust(width) for cell in cells)}")
    return "\n".join(lines)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("--data", type=Path, metavar="FOLDER", help="evaluation data, with labels.csv")
    parser.add_argument(
        "--kinds", nargs="+", default=KINDS, metavar="KIND", help=f"of creatures ({', '.join(KINDS)})"
    )
    parser.add_argument(
        "--seeds", type=int, nargs="+", default=SEEDS, metavar="N", help="of creatures and transformations"
    )
    parser.add_argument(
        "--strengths", type=int, nargs="+", choices=range(1, 6), default=STRENGTHS, metavar="N"
    )
    parser.add_argument(
        "--preparation",
        choices=("preprocessed", "paper"),
        default="preprocessed",
        help="of the meshes (%(default)s)",
    )
    parser.add_argument(
        "--jobs", type=number_from(1), default=1, metavar="N", help="worker processes (%(default)s)"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures here")


def run(options: argparse.Namespace) -> int:
    """Measure the detectors and print the table.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    nulls = null_shapes(options)
    measured = map_in_processes(partial(measure, options), nulls, options.jobs, "null shapes")
    rows = [row for found in measured for row in found]
    if not rows:
        print("nothing was measured", file=sys.stderr)
        return 2
    figures = summary(rows)
    print(table(figures))
    if options.json is not None:
        options.json.write_text(json.dumps({"summary": figures, "rows": rows}, indent=1), encoding="utf-8")
    return 0
