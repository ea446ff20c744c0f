# SPDX-License-Identifier: MIT
"""Measure searches and the kinds of the best 10 and 50 matches as multiples of describing the same query.

Libraries hold creatures of 3,000 vertices: 31 kinds, as many individuals as it takes, each in two poses.
Queries of 10,000 vertices are some individuals of the library, another pose of each, and half of each. Bags
are conclusive for the first two only. With --keep FOLDER the libraries stay there for the next run.
"""

from __future__ import annotations

import statistics
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

SIZES, REPEATS = (468, 1_753), 3
SEED, POSES, LIBRARY_VERTICES, QUERY_VERTICES = 1_000, 2, 3_000, 10_000
INDIVIDUALS = ("horse", "spider", "human")
STEPS = ("describe", "search", "kinds_10", "kinds_50")


def measure(options: Options) -> Iterator[Row]:
    """Measure all queries in libraries of all sizes.

    Parameters
    ----------
    options : Options
        Sizes are numbers of shapes.

    Yields
    ------
    row : dict
        Of one sort of query: medians of seconds of processor time, and of their multiples of describing the
        same query. "first" is the first search after opening the library.
    """
    model = sg.load_model()
    folder = options.folder if options.keep is None else options.keep
    folder.mkdir(parents=True, exist_ok=True)
    queries = _queries()
    for size in sorted(options.sizes):
        path = folder / f"creatures-{model.identifier}-{size}.sglib"
        _fill(path, size, model, sorted(folder.glob(f"creatures-{model.identifier}-*.sglib")))
        for name, meshes in queries.items():
            times: dict[str, list[float]] = {step: [] for step in ("first", *STEPS)}
            for mesh in meshes:
                with sg.Library.open(path, read_only=True) as library:
                    times["first"].append(_first(library, mesh))
                    for _ in range(options.repeats):
                        _time(library, mesh, times)
            yield {"shapes": size, "query": name} | _row(times)


def _queries() -> dict[str, list[sg.Mesh]]:
    made = [make_creature(kind, SEED, QUERY_VERTICES) for kind in INDIVIDUALS]
    return {
        "in the library": [creature.pose(0) for creature in made],
        "another pose": [creature.pose(2) for creature in made],
        "half": [cut(creature.pose(0), np.array([1.0, 0.3, 0.2]), 0.5) for creature in made],
    }


def _fill(path: Path, size: int, model: sg.ShapeModel, others: Sequence[Path]) -> None:
    """Add creatures to a library until it has this size; those of other such libraries are copied."""
    with sg.Library.open(path, model) as library:
        known = len(library)
        for other in others:
            if known < size and other != path:
                with sg.Library.open(other, read_only=True) as source:
                    for record in list(source.shapes())[known:size]:
                        library.add_signature(source.signature(record.shape_id), record.name)
                known = len(library)
        for number in range(known, size):
            seed, kind = divmod(number // POSES, len(CREATURE_KINDS))
            creature = make_creature(CREATURE_KINDS[kind], SEED + seed, LIBRARY_VERTICES)
            pose = number % POSES
            library.add(creature.pose(pose), f"{CREATURE_KINDS[kind]} {SEED + seed} {pose}")


def _first(library: sg.Library, mesh: sg.Mesh) -> float:
    """Time the first search in a library, which reads all codes and the traits of the candidates."""
    signature = library.model.describe(mesh, keep_surface=True)
    started = time.process_time()
    library.query(signature, top=50, explain=0)
    return time.process_time() - started


def _time(library: sg.Library, mesh: sg.Mesh, times: dict[str, list[float]]) -> None:
    """Time all steps of one query once."""

    def timed(step: str, run: Callable[..., T], *arguments: object, **options: object) -> T:
        started = time.process_time()
        result = run(*arguments, **options)
        times[step].append(time.process_time() - started)
        return result

    signature = timed("describe", library.model.describe, mesh, keep_surface=True)
    matches = timed("search", library.query, signature, top=50, explain=0)
    timed("kinds_10", library.explain, signature, matches[:10], 10)
    timed("kinds_50", library.explain, signature, matches, 50)


def _row(times: dict[str, list[float]]) -> Row:
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
    names = [f"{row['query']}, {row['shapes']:,} shapes" for row in rows]
    for place, step in enumerate(STEPS):
        heights = np.arange(len(rows)) + 0.2 * place
        axes.barh(heights, [row[step] for row in rows], 0.18, label=step.replace("_", " of the best "))
    axes.set(xlabel="seconds of processor time", yticks=np.arange(len(rows)) + 0.3, yticklabels=names)
    axes.invert_yaxis()
    axes.legend(fontsize="small")
    return figure
