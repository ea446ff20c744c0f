# SPDX-License-Identifier: MIT
"""Measure what the neighbour graph costs: for a new shape, for indexing without new shapes, and in a search.

Libraries hold made-up shapes of the shipped model, whose links are made up too, as those of kinds of 50
shapes. Only the last shapes, which are measured, find their neighbours in the usual way. Sizes are numbers
of shapes; 100,000 take 4 GB of disk.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import shapegoogle_core as sg
from benchmarks.speed.measuring import Options, Row
from benchmarks.speed.reporting import panels
from benchmarks.studio.made_up import made_up_shapes, real_signatures
from shapegoogle_core.library.neighbours.graph import NeighbourGraph
from shapegoogle_core.library.neighbours.pairs import TraitPairs
from shapegoogle_core.library.search.settings import WalkSettings
from shapegoogle_core.library.search.traits.stored import StoredTraits
from shapegoogle_core.library.storage.opening import open_store
from shapegoogle_core.library.storage.store import Neighbours

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["REPEATS", "SIZES", "draw", "measure"]

SIZES, REPEATS = (1_000, 100_000), 20
AT_ONCE, OF_A_KIND, LINKS = 500, 50, 10
STEPS = ("stored", "related", "nothing_new", "search", "walk")


def measure(options: Options) -> Iterator[Row]:
    """Measure libraries of all sizes.

    Parameters
    ----------
    options : Options
        Sizes are numbers of shapes; as many shapes are added and searched as there are repeats.

    Yields
    ------
    row : dict
        Of one size, medians of milliseconds of processor time: "stored", adding a shape without neighbours;
        "related", with them; "nothing_new", completing a graph that is complete; "search", a search that
        orders 300 matches; "walk", the walk in it.
    """
    model = sg.load_model()
    for size in options.sizes:
        path = options.folder / f"{size}.sglib"
        _fill(path, size, model)
        with sg.Library.open(path, model) as library:
            stored, related = _adding(library, size, options.repeats)
            library.update_neighbours()
            complete = [_milliseconds(library.update_neighbours) for _ in range(3)]
            searches, walks = _searches(library, path, options.repeats)
        yield {
            "shapes": size,
            "stored": round(statistics.median(stored), 1),
            "related": round(statistics.median(related), 1),
            "nothing_new": round(statistics.median(complete), 1),
            "search": round(statistics.median(searches), 1),
            "walk": round(statistics.median(walks), 1),
        }
        path.unlink()


def _fill(path: Path, size: int, model: sg.ShapeModel) -> None:
    """Make a library, with made-up links."""
    with sg.Library.open(path, model) as library, library.neighbours_later():
        for start in range(0, size, AT_ONCE):
            shapes = made_up_shapes(model, range(start, min(start + AT_ONCE, size)))
            library.replace_source(f"made-up/{start}", size=0, mtime_ns=0, sha256=None, shapes=shapes)
    store, _ = open_store(path, None, read_only=False, timeout=60)
    with closing(store):
        shape_ids = store.without_neighbours(0, size)
        random = np.random.default_rng(0)
        for start in range(0, size, AT_ONCE):
            links: dict[int, Neighbours] = {}
            for first in range(start, start + AT_ONCE, OF_A_KIND):
                links |= _made_up_links(shape_ids[first : first + OF_A_KIND], random)
            store.put_neighbours(links)


def _adding(library: sg.Library, size: int, repeats: int) -> tuple[list[float], list[float]]:
    """Time adding shapes without and with their neighbours, in turns."""
    library.query(real_signatures()[0], top=1, explain=0)  # reads all codes
    stored, related = [], []
    for number in range(size, size + 2 * repeats, 2):
        first, second = made_up_shapes(library.model, [number, number + 1])
        with library.neighbours_later():
            stored.append(_milliseconds(lambda: library.add_signature(first.signature, first.name)))  # noqa: B023
        related.append(_milliseconds(lambda: library.add_signature(second.signature, second.name)))  # noqa: B023
    return stored, related


def _made_up_links(shape_ids: Sequence[int], random: np.random.Generator) -> dict[int, Neighbours]:
    """Link the shapes of a kind with some of it."""
    links = {}
    for shape_id in shape_ids:
        others = [other for other in shape_ids if other != shape_id]
        chosen = random.permutation(others)[:LINKS].astype(np.int64)
        links[shape_id] = (chosen, np.sort(random.uniform(0.1, 0.6, len(chosen))).astype(np.float32))
    return links


def _searches(library: sg.Library, path: Path, repeats: int) -> tuple[list[float], list[float]]:
    """Time searches, and the walk over the neighbours of their matches."""
    searches, walks = [], []
    store, model = open_store(path, None, read_only=True, timeout=60)
    with closing(store):
        pairs = TraitPairs(StoredTraits(store, model))
        graph = NeighbourGraph(store, lambda _: [], pairs, WalkSettings(), model.code_bits // 8)
        for shape in made_up_shapes(model, range(10**7, 10**7 + repeats)):
            started = time.process_time()
            matches = library.query(shape.signature, top=WalkSettings.walked, explain=0)
            searches.append(1_000 * (time.process_time() - started))
            ids, distances = [match.shape_id for match in matches], [match.distance for match in matches]
            started = time.process_time()
            graph.distances(ids, distances)
            walks.append(1_000 * (time.process_time() - started))
    return searches, walks


def _milliseconds(run: Callable[[], object]) -> float:
    started = time.process_time()
    run()
    return 1_000 * (time.process_time() - started)


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the processor time of each step against the size of the library.

    Parameters
    ----------
    rows : sequence of dict
        From `measure`.

    Returns
    -------
    figure : matplotlib.figure.Figure
    """
    figure, (axes,) = panels(1, 6, 4)
    for step in STEPS:
        axes.loglog(
            [row["shapes"] for row in rows], [row[step] for row in rows], "o-", label=step.replace("_", " ")
        )
    axes.set(xlabel="shapes", ylabel="milliseconds of processor time")
    axes.legend(fontsize="small")
    return figure
