# SPDX-License-Identifier: MIT
"""Changes between two runs: figures of the table and ranks of queries."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.protocol.results.run import BenchmarkResult, VariantResult

__all__ = ["Change", "QueryChange", "compare", "compare_queries"]


@dataclass(frozen=True)
class Change:
    """One figure of the table in two runs.

    Attributes
    ----------
    variant : str
    transformation : str
        A class, or "average".
    before, after : float
        Mean average precision at strength ≤ 5, 0 … 100.
    """

    variant: str
    transformation: str
    before: float
    after: float

    @property
    def difference(self) -> float:
        """Increase of the figure."""
        return self.after - self.before


@dataclass(frozen=True)
class QueryChange:
    """One query in two runs.

    Attributes
    ----------
    query : str
    before, after : float
        Ranks.
    first_before, first_after : str
        Names of the first matches.
    """

    query: str
    before: float
    after: float
    first_before: str
    first_after: str

    @property
    def difference(self) -> float:
        """Increase of the reciprocal rank, −1 … 1."""
        return 1 / self.after - 1 / self.before


def compare(a: BenchmarkResult, b: BenchmarkResult) -> list[Change]:
    """List the changes of figures between two runs.

    Parameters
    ----------
    a, b : BenchmarkResult
        The earlier and the later one.

    Returns
    -------
    changes : list of Change
        For every variant of both runs, in the order of `b`: one for each class, and the average.
    """
    changes = []
    for after in b.variants:
        before = a.variant(after.name)
        if before is not None:
            changes += [
                Change(after.name, kind, before.table[kind][-1], row[-1])
                for kind, row in after.table.items()
                if kind in before.table
            ]
    return changes


def compare_queries(a: VariantResult, b: VariantResult) -> list[QueryChange]:
    """List the queries whose rank changed between two runs of a variant.

    Parameters
    ----------
    a, b : VariantResult
        The earlier and the later one.

    Returns
    -------
    changes : list of QueryChange
        Largest changes first.
    """
    earlier = {outcome.query: outcome for outcome in a.outcomes}
    changes = [
        QueryChange(after.query, before.rank, after.rank, before.first, after.first)
        for after in b.outcomes
        if (before := earlier.get(after.query)) is not None and before.rank != after.rank
    ]
    return sorted(changes, key=lambda change: (-abs(change.difference), change.query))
