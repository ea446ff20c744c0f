# SPDX-License-Identifier: MIT
"""Measure the kinds of the best 10 and 50 matches, beside describing the query and the search.

The library holds 124 creatures: 31 kinds, two individuals each, in two poses. Queries are a horse that is in
the library, another pose of it, and half of it, so that bags are conclusive for the first two only.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.experiments.evidence_pairs import cut
from benchmarks.speed.measuring import Options, Row
from benchmarks.speed.reporting import panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["REPEATS", "SIZES", "draw", "measure"]

T = TypeVar("T")

SIZES, REPEATS = (10_000,), 3
SEED, INDIVIDUALS, LIBRARY_VERTICES = 1_000, 2, 3_000
STEPS = ("describe", "search", "kinds_10", "kinds_50")


def measure(options: Options) -> Iterator[Row]:
    """Measure all queries.

    Parameters
    ----------
    options : Options
        Sizes are numbers of vertices of the query.

    Yields
    ------
    row : dict
        Seconds of processor time, and those of the kinds as multiples of describing the query.
    """
    model = sg.load_model()
    with (
        tempfile.TemporaryDirectory(dir=options.folder) as folder,
        sg.Library.open(Path(folder) / "creatures.sglib", model) as library,
    ):
        for kind in CREATURE_KINDS:
            for seed in range(SEED, SEED + INDIVIDUALS):
                individual = make_creature(kind, seed, LIBRARY_VERTICES)
                for pose in (0, 1):
                    library.add(individual.pose(pose), f"{kind} {seed} {pose}")
        for size in options.sizes:
            horse = make_creature("horse", SEED, size)
            queries = {
                "in the library": horse.pose(0),
                "another pose": horse.pose(2),
                "half": cut(horse.pose(0), np.array([1.0, 0.3, 0.2]), 0.5),
            }
            for name, mesh in queries.items():
                yield {"query": name, "vertices": size} | _times(library, mesh, options.repeats)


def _times(library: sg.Library, mesh: sg.Mesh, repeats: int) -> Row:
    times: dict[str, list[float]] = {step: [] for step in STEPS}

    def timed(step: str, run: Callable[..., T], *arguments: object, **options: object) -> T:
        started = time.process_time()
        result = run(*arguments, **options)
        times[step].append(time.process_time() - started)
        return result

    for _ in range(repeats):
        signature = timed("describe", library.model.describe, mesh, keep_surface=True)
        matches = timed("search", library.query, signature, top=50, explain=0)
        timed("kinds_10", library.explain, signature, matches[:10], 10)
        timed("kinds_50", library.explain, signature, matches, 50)
    row: Row = {step: round(statistics.median(values), 3) for step, values in times.items()}
    return row | {
        f"{step}_ratio": round(
            statistics.median(one / other for one, other in zip(times[step], times["describe"], strict=True)),
            2,
        )
        for step in STEPS[1:]
    }


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the processor time of each step.

    Parameters
    ----------
    rows : sequence of dict
        From `measure`.

    Returns
    -------
    figure : matplotlib.figure.Figure
    """
    figure, (axes,) = panels(1, 8, 1 + 0.6 * len(rows))
    names = [f"{row['query']}, {row['vertices']:,} vertices" for row in rows]
    for place, step in enumerate(STEPS):
        heights = np.arange(len(rows)) + 0.2 * place
        axes.barh(heights, [row[step] for row in rows], 0.18, label=step.replace("_", " of the best "))
    axes.set(xlabel="seconds of processor time", yticks=np.arange(len(rows)) + 0.3, yticklabels=names)
    axes.invert_yaxis()
    axes.legend(fontsize="small")
    return figure
