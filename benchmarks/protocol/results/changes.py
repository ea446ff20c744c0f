# SPDX-License-Identifier: MIT
"""What changed between two runs: figures of the table, and single queries."""

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
        """How much better it is now."""
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
        What stood first.
    """

    query: str
    before: float
    after: float
    first_before: str
    first_after: str

    @property
    def difference(self) -> float:
        """How much the reciprocal rank grew, −1 … 1."""
        return 1 / self.after - 1 / self.before


def compare(a: BenchmarkResult, b: BenchmarkResult) -> list[Change]:
    """Say what changed between two runs.

    Parameters
    ----------
    a, b : BenchmarkResult
        The earlier and the later one.

    Returns
    -------
    changes : list of Change
        One for each class, and the average, of every variant that both have, in the order of `b`.
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
    """Say which queries fared otherwise in two runs of a variant.

    Parameters
    ----------
    a, b : VariantResult
        The earlier and the later one.

    Returns
    -------
    changes : list of QueryChange
        Queries that both asked and whose rank changed, what changed most first.
    """
    earlier = {outcome.query: outcome for outcome in a.outcomes}
    changes = [
        QueryChange(after.query, before.rank, after.rank, before.first, after.first)
        for after in b.outcomes
        if (before := earlier.get(after.query)) is not None and before.rank != after.rank
    ]
    return sorted(changes, key=lambda change: (-abs(change.difference), change.query))
