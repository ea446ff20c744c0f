# SPDX-License-Identifier: MIT
"""The table of classes as text, for the terminal and for Markdown."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

from benchmarks.protocol.metrics import AVERAGE
from benchmarks.protocol.results import BenchmarkResult, VariantResult

__all__ = ["chosen_variants", "class_names", "text_table"]

_COLUMN_WIDTH = 12


def chosen_variants(result: BenchmarkResult, most: int = 6) -> list[VariantResult]:
    """Choose the variants to show side by side.

    Parameters
    ----------
    result : BenchmarkResult
    most : int

    Returns
    -------
    variants : list of VariantResult
        First the search; then the best variant of each other family, the remaining models and the variants
        with the highest averages, sorted by their averages.
    """
    ranked = sorted(result.variants, key=_goodness, reverse=True)
    best = {family: _first_of(ranked, family) for family in ("codes", "bags", "baseline")}
    wanted = [result.search, *best.values()]
    wanted += [variant for variant in ranked if variant.family == "model"]
    wanted += ranked
    picked = list({variant.name: variant for variant in wanted if variant is not None}.values())[:most]
    return sorted(picked, key=lambda variant: (variant is not result.search, -_goodness(variant)))


def _first_of(variants: Sequence[VariantResult], family: str) -> VariantResult | None:
    return next((variant for variant in variants if variant.family == family), None)


def _goodness(variant: VariantResult) -> float:
    return -math.inf if math.isnan(variant.average) else variant.average


def class_names(result: BenchmarkResult) -> list[str]:
    """List the transformation classes of a result.

    Parameters
    ----------
    result : BenchmarkResult

    Returns
    -------
    names : list of str
        In the order of its tables, "average" last.
    """
    names = dict.fromkeys(name for variant in result.variants for name in variant.table)
    names.pop(AVERAGE, None)
    return [*names, AVERAGE]


def text_table(result: BenchmarkResult) -> str:
    """Format the table of classes for a terminal.

    Parameters
    ----------
    result : BenchmarkResult

    Returns
    -------
    table : str
        Mean average precision × 100 at strength ≤ 5: a line for each class, a column for each of
        `chosen_variants`.
    """
    variants = chosen_variants(result)
    if not variants:
        return "nothing was measured"
    heads = [_wrapped(variant.name) for variant in variants]
    widths = [max(len(line) for line in head) for head in heads]
    names = class_names(result)
    first = max(len(name) for name in names)
    tallest = max(len(head) for head in heads)
    lines = []
    for row in range(tallest):
        cells = [
            (head[row - tallest + len(head)] if row >= tallest - len(head) else "").rjust(width)
            for head, width in zip(heads, widths, strict=True)
        ]
        lines.append("  ".join([" " * first, *cells]))
    rule = "  ".join("─" * width for width in [first, *widths])
    for name in names:
        if name in (names[0], AVERAGE):
            lines.append(rule)
        cells = [_figure(variant, name).rjust(width) for variant, width in zip(variants, widths, strict=True)]
        lines.append("  ".join([_plain(name).ljust(first), *cells]))
    return "\n".join(line.rstrip() for line in lines)


def _wrapped(name: str) -> list[str]:
    """Break a heading into lines: one for each part of the name, more for long parts."""
    return [
        line
        for part in name.split(" · ")
        for line in textwrap.wrap(part, _COLUMN_WIDTH, break_on_hyphens=False)
    ] or [""]


def _figure(variant: VariantResult, name: str) -> str:
    value = variant.table.get(name, [math.nan])[-1]
    return "–" if math.isnan(value) else f"{value:.1f}"


def _plain(name: str) -> str:
    return name.replace("_", " ")
