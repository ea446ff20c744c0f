# SPDX-License-Identifier: MIT
"""Variants of the search: their names, and their distances from queries to a database."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from benchmarks.protocol.cache import Arrays
from benchmarks.protocol.collection import BenchmarkShape
from benchmarks.protocol.workshop import Workshop
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["Matched", "Variant", "VariantGroup", "between", "median_seconds", "stacked"]


@dataclass(frozen=True)
class Variant:
    """One row of the benchmark's table.

    Attributes
    ----------
    name : str
        Unique.
    family : {"baseline", "bags", "codes", "model"}
    parameters : dict of str to str, int or float
        Columns of the table of all variants.
    headline : bool
        Whether labelled collections are scored too.
    """

    name: str
    family: str
    parameters: dict[str, str | int | float] = field(default_factory=dict, hash=False)
    headline: bool = False


@dataclass(frozen=True, eq=False)
class Matched:
    """Distances of a variant.

    Attributes
    ----------
    variant : Variant
    distances : (q, d) array
        Infinite to or from a shape that could not be described.
    seconds : float
        Time to match one described query with the described database.
    bytes_per_shape : int
        Size of what is stored of a database shape for matching.
    describe_seconds : float
        As in `VariantResult`.
    """

    variant: Variant
    distances: FloatArray
    seconds: float
    bytes_per_shape: int
    describe_seconds: float


class VariantGroup(Protocol):
    """Variants that share a description of each shape."""

    @property
    def variants(self) -> tuple[Variant, ...]:
        """In the order of the table."""

    def only(self, names: set[str]) -> Self:
        """Return the group without the variants of other names."""

    def match(
        self, workshop: Workshop, queries: Sequence[BenchmarkShape], database: Sequence[BenchmarkShape]
    ) -> Iterator[Matched]:
        """Compare all queries with the database, for each of the variants."""


def between(
    variant: Variant,
    distance: Callable[[FloatBags, FloatBags], FloatArray],
    queries: FloatBags,
    database: FloatBags,
    bytes_per_shape: int,
    describe_seconds: float,
) -> Matched:
    """Compare described shapes.

    Parameters
    ----------
    variant : Variant
    distance : callable
        Takes (q, …) and (d, …) rows without NaN, returns a (q, d) array.
    queries, database : (q, …) and (d, …) arrays
        From `stacked`: rows of NaN are shapes that failed.
    bytes_per_shape : int
    describe_seconds : float

    Returns
    -------
    matched : Matched
    """
    asked, known = ~_failed(queries), ~_failed(database)
    distances = np.full((len(queries), len(database)), np.inf)
    started = time.perf_counter()
    if asked.any() and known.any():
        distances[np.ix_(asked, known)] = distance(queries[asked], database[known])
    seconds = (time.perf_counter() - started) / max(int(asked.sum()), 1)
    return Matched(variant, distances, seconds, bytes_per_shape, describe_seconds)


def stacked(descriptions: Sequence[Arrays | None], name: str) -> FloatBags:
    """Stack descriptions, one row for each shape.

    Parameters
    ----------
    descriptions : sequence of dict of str to array, or None
        From `Workshop.describe`.
    name : str
        Of the array.

    Returns
    -------
    rows : (n, …) array of float32
        NaN for shapes that failed.
    """
    size = next((entry[name].shape for entry in descriptions if entry is not None), (1,))
    rows = np.full((len(descriptions), *size), np.nan, np.float32)
    for row, entry in zip(rows, descriptions, strict=True):
        if entry is not None:
            row[...] = entry[name]
    return rows


def median_seconds(descriptions: Iterable[Arrays | None]) -> float:
    """Compute the median processor time of the descriptions that did not fail.

    Parameters
    ----------
    descriptions : iterable of dict of str to array, or None
        From `Workshop.describe`; "seconds" is the time, which the cache keeps too.

    Returns
    -------
    seconds : float
        NaN if all failed.
    """
    times = [float(entry["seconds"]) for entry in descriptions if entry is not None]
    return float(np.median(times)) if times else float("nan")


def _failed(rows: FloatBags) -> NDArray[np.bool_]:
    return np.asarray(np.isnan(rows).any(axis=tuple(range(1, rows.ndim))), dtype=np.bool_)
