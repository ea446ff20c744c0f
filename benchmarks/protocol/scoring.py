# SPDX-License-Identifier: MIT
"""Scoring of a variant's distances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.metrics import AVERAGE, precision_recall, ranks, roc, strength_table
from benchmarks.protocol.results import Parameter, QueryOutcome, VariantResult

__all__ = ["score_variant"]


class Query(Protocol):
    """A query, such as a `BenchmarkShape`."""

    @property
    def name(self) -> str:
        """Name of the query."""

    @property
    def relevant(self) -> str:
        """Name of the database shape it should find."""

    @property
    def transformation(self) -> str:
        """Transformation class."""

    @property
    def strength(self) -> int:
        """1 … 5."""


def score_variant(
    name: str,
    family: str,
    parameters: Mapping[str, Parameter],
    distances: ArrayLike,
    queries: Sequence[Query],
    database: Sequence[str],
    seconds: float,
    bytes_per_shape: int,
    describe_seconds: float = math.nan,
) -> VariantResult:
    """Score distances from queries to a database with all measures.

    Parameters
    ----------
    name, family, parameters, seconds, bytes_per_shape, describe_seconds
        As in `VariantResult`.
    distances : (q, d) array_like
        Infinite for a shape that could not be described. A query without finite distances failed and counts
        as if its relevant shape were last.
    queries : sequence of q BenchmarkShape
    database : sequence of d str
        Names.

    Returns
    -------
    result : VariantResult

    Raises
    ------
    BenchmarkError
        If a query's relevant shape is not in the database.
    ValueError
        If the distances do not fit or are NaN.
    """
    column = {shape: position for position, shape in enumerate(database)}
    missing = [query for query in queries if query.relevant not in column]
    if missing:
        raise BenchmarkError(
            f"query {missing[0].name!r} should find {missing[0].relevant!r}, which is not in the database"
        )
    matrix = np.asarray(distances, float)
    relevant = np.array([column[query.relevant] for query in queries], int)
    places = ranks(matrix, relevant)
    if matrix.shape[1] != len(database):
        raise ValueError(f"distances are to {matrix.shape[1]} shapes, but the database has {len(database)}")
    failed = np.isinf(matrix).all(axis=1)
    places[failed] = len(database)
    outcomes = []
    for row, query in enumerate(queries):
        wanted, first = relevant[row], int(matrix[row].argmin())
        # A tie for the first rank is not an error; the rank reflects it.
        first = int(wanted) if matrix[row, wanted] == matrix[row, first] else first
        outcomes.append(
            QueryOutcome(
                query.name,
                query.transformation,
                query.strength,
                query.relevant,
                float(places[row]),
                "" if failed[row] else database[first],
                float(matrix[row, wanted]),
                float(matrix[row, first]),
            )
        )
    table = strength_table(
        places, [query.transformation for query in queries], [query.strength for query in queries]
    )
    mask = np.arange(len(database)) == relevant[:, None]
    told_apart = len(database) > 1
    curve = roc(matrix, mask) if told_apart else None
    return VariantResult(
        name=name,
        family=family,
        parameters=dict(parameters),
        outcomes=tuple(outcomes),
        table=table,
        average=table[AVERAGE][-1],
        equal_error_rate=curve.equal_error_rate if curve else math.nan,
        roc=curve.points() if curve else [],
        precision_recall=precision_recall(matrix, mask).points() if told_apart else [],
        seconds=seconds,
        bytes_per_shape=bytes_per_shape,
        describe_seconds=describe_seconds,
    )
