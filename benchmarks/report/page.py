# SPDX-License-Identifier: MIT
"""The report: one HTML page with tables, plots and pictures."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2

from benchmarks.protocol.collection import Collection
from benchmarks.protocol.metrics import AVERAGE, STRENGTHS
from benchmarks.protocol.results import (
    BenchmarkResult,
    Change,
    QueryChange,
    VariantResult,
    compare,
    compare_queries,
)
from benchmarks.protocol.tables import chosen_variants, class_names
from benchmarks.report.pictures import worst_failures
from benchmarks.report.plots import (
    SERIES,
    bit_plots,
    precision_recall_plot,
    roc_plot,
    strength_plots,
    vocabulary_plots,
)

__all__ = ["write_report"]

FAILURES = 24
CHANGED_QUERIES = 20


@dataclass(frozen=True)
class _Column:
    """A column of the overview.

    Attributes
    ----------
    title : str
    kind : {"figure", "text"}
    show : callable
        Formats a value of a cell.
    lowest_is_best : bool or None
        None if the column has no best value.
    is_parameter : bool
        Such columns are not printed, because the variant's name has the same information.
    """

    title: str
    kind: str
    show: Callable[[Any], str]
    lowest_is_best: bool | None = None
    is_parameter: bool = False


def write_report(
    result: BenchmarkResult,
    collection: Collection,
    folder: Path,
    compare_with: BenchmarkResult | None = None,
) -> Path:
    """Write the report as one self-contained page.

    Parameters
    ----------
    result : BenchmarkResult
    collection : Collection
        The measured collection; its shapes are read again for the pictures.
    folder : Path
        Made if it does not exist.
    compare_with : BenchmarkResult, optional
        Result of an earlier run, to show the changes.

    Returns
    -------
    page : Path
        ``index.html`` in the folder.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {
        "figure": _figure,
        "plain": _plain,
        "rank": _rank,
        "number": _number,
        "tint": _tint,
    }
    chosen = chosen_variants(result, len(SERIES))
    search = result.search
    text = environment.get_template("page.html.jinja").render(
        result=result,
        date=_date(result),
        chosen=chosen,
        series=SERIES,
        search=search,
        classes=class_names(result),
        hardest=_hardest(search),
        strengths=STRENGTHS,
        overview=_overview(result),
        strength_plots=strength_plots(chosen, class_names(result)),
        curve_plots=[plot for plot in (precision_recall_plot(chosen), roc_plot(chosen)) if plot],
        vocabulary_plots=vocabulary_plots(result.variants),
        bit_plots=bit_plots(result.variants),
        failures=list(worst_failures(search, collection, FAILURES)) if search else [],
        database=collection.counts()["database"],
        comparison=_comparison(result, compare_with) if compare_with else None,
        has_json=(folder / "benchmark.json").is_file(),
    )
    folder.mkdir(parents=True, exist_ok=True)
    page = folder / "index.html"
    page.write_text(text, encoding="utf-8")
    return page


def _date(result: BenchmarkResult) -> str:
    """Format day and time to the minute, without the zone."""
    return result.date[:16].replace("T", " ")


def _hardest(search: VariantResult | None) -> list[tuple[str, float]]:
    """Find the two classes with the lowest precision."""
    if search is None:
        return []
    rows = [(name, row[-1]) for name, row in search.table.items() if name != AVERAGE and row[-1] < 99.95]
    return sorted(rows, key=lambda row: row[1])[:2]


def _overview(result: BenchmarkResult) -> dict[str, Any]:
    """Make columns and rows of the table of all variants; missing values are None."""
    names = class_names(result)
    # Quality and cost come first: the classes do not fit on every screen.
    columns = [
        _Column("variant", "text", str),
        _Column(AVERAGE, "figure", _figure, False),
        _Column("found first %", "figure", _figure, False),
        _Column("equal error %", "figure", lambda value: f"{value:.2f}", True),
        _Column("bytes per shape", "figure", _whole, True),
        _Column("ms per query", "figure", _milliseconds, True),
        _Column("CPU ms to describe", "figure", _milliseconds, True),
    ]
    columns += [_Column(name, "figure", _figure, False) for name in names[:-1]]
    columns.append(_Column("family", "text", str))
    parameters = list(dict.fromkeys(key for variant in result.variants for key in variant.parameters))
    for key in parameters:
        kind = "figure" if _all_numbers(result.variants, key) else "text"
        columns.append(_Column(key, kind, _number, is_parameter=True))
    rows = []
    for variant in sorted(result.variants, key=lambda variant: (-variant.average, variant.name)):
        values: list[Any] = [variant.name, variant.average]
        values += [100 * variant.found_within(1), 100 * variant.equal_error_rate]
        values += [variant.bytes_per_shape, 1000 * variant.seconds, 1000 * variant.describe_seconds]
        values += [variant.table.get(name, [math.nan])[-1] for name in names[:-1]]
        values.append(variant.family)
        values += [variant.parameters.get(key) for key in parameters]
        rows.append([None if isinstance(value, float) and math.isnan(value) else value for value in values])
    best = [_best(column, [row[position] for row in rows]) for position, column in enumerate(columns)]
    return {"columns": columns, "rows": rows, "best": best}


def _all_numbers(variants: Sequence[VariantResult], key: str) -> bool:
    return all(isinstance(variant.parameters.get(key, 0), int | float) for variant in variants)


def _best(column: _Column, values: Sequence[Any]) -> str | None:
    """Return the text of the best cell, or None if all cells are alike."""
    known = [value for value in values if value is not None]
    if column.lowest_is_best is None or len({column.show(value) for value in known}) < 2:
        return None
    return column.show(min(known) if column.lowest_is_best else max(known))


def _comparison(result: BenchmarkResult, earlier: BenchmarkResult) -> dict[str, Any]:
    """Collect the changes: of the search by class and query, of the other variants by their average."""
    changes: dict[str, list[Change]] = {}
    for change in compare(earlier, result):
        changes.setdefault(change.variant, []).append(change)
    queries: list[QueryChange] = []
    search = result.search
    if search is not None and (before := earlier.variant(search.name)) is not None:
        queries = compare_queries(before, search)
    averages = [rows[-1] for rows in changes.values()]
    return {
        "earlier": earlier,
        "date": _date(earlier),
        "search": changes.get(search.name, []) if search else [],
        "others": sorted(
            (change for change in averages if search is None or change.variant != search.name),
            key=lambda change: -abs(change.difference),
        ),
        "queries": queries[:CHANGED_QUERIES],
        "better": sum(change.difference > 0 for change in queries),
        "worse": sum(change.difference < 0 for change in queries),
        "same_queries": (earlier.counts, earlier.seed) == (result.counts, result.seed),
    }


def _figure(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.1f}"


def _milliseconds(value: float) -> str:
    return f"{value:.3g}" if value < 100 else _whole(value)


def _whole(value: float) -> str:
    return f"{value:,.0f}"


def _number(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _rank(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")


def _plain(name: str) -> str:
    return name.replace("_", " ")


def _tint(value: float) -> int:
    """Return the strength of a cell's colour in %: 0 at a value of 100, 60 at 40 and below."""
    return 0 if math.isnan(value) else round(min(max(100 - value, 0), 60))
