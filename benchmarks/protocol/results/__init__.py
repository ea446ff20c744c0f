# SPDX-License-Identifier: MIT
"""Results of a benchmark: JSON files and comparison of runs."""

from benchmarks.protocol.results.changes import Change, QueryChange, compare, compare_queries
from benchmarks.protocol.results.run import (
    BenchmarkResult,
    CategoryResult,
    Parameter,
    Problem,
    QueryOutcome,
    VariantResult,
    load_result,
    save_result,
)

__all__ = [
    "BenchmarkResult",
    "CategoryResult",
    "Change",
    "Parameter",
    "Problem",
    "QueryChange",
    "QueryOutcome",
    "VariantResult",
    "compare",
    "compare_queries",
    "load_result",
    "save_result",
]
