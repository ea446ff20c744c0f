# SPDX-License-Identifier: MIT
"""Results of a run, as plain data in JSON files."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.metrics import CategoryScores

__all__ = [
    "BenchmarkResult",
    "CategoryResult",
    "Parameter",
    "Problem",
    "QueryOutcome",
    "VariantResult",
    "load_result",
    "save_result",
]

Parameter = str | int | float

_FORMAT = 1
_RESULT = "name a benchmark.json written by `python -m benchmarks retrieval`"


def _number(value: Any) -> Any:
    """Round a float to seven digits, enough for plots and comparisons; None if it is not finite."""
    if not isinstance(value, float):
        return value
    return float(f"{value:.7g}") if math.isfinite(value) else None


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


@dataclass(frozen=True)
class QueryOutcome:
    """Outcome of one query.

    Attributes
    ----------
    query : str
    transformation : str
    strength : int
    relevant : str
        Name of its null shape.
    rank : float
        Rank of that shape; 1 is the first, and shapes at equal distances share their ranks.
    first : str
        Name of the first match; the null shape if it shares the first rank. Empty for a query that failed,
        whose rank is the size of the database.
    distance_relevant, distance_first : float
        Not finite for a query that failed.
    """

    query: str
    transformation: str
    strength: int
    relevant: str
    rank: float
    first: str
    distance_relevant: float
    distance_first: float

    @property
    def failed(self) -> bool:
        """Whether the query could not be described."""
        return not self.first


@dataclass(frozen=True)
class VariantResult:
    """Result of one variant.

    Attributes
    ----------
    name : str
        Unique, for example "HKS · spatially sensitive bag · 48 words".
    family : {"baseline", "bags", "codes", "model"}
    parameters : dict of str to str, int or float
        Columns of the table of all variants: "descriptor", "bag", "words", "bits", "projection",
        "preparation", …
    outcomes : tuple of QueryOutcome
    table : dict of str to list of 5 floats
        As from `metrics.strength_table`.
    average : float
        Of the classes at strength ≤ 5, 0 … 100.
    equal_error_rate : float
        0 … 1; NaN where distances of different queries cannot be compared.
    roc : list of [float, float]
        False and true positive rate, at most 200 points.
    precision_recall : list of [float, float]
        Recall and precision, at most 200 points.
    seconds : float
        Time to match one described query with the described database.
    bytes_per_shape : int
        Size of what is stored of a database shape for matching.
    describe_seconds : float
        Median processor time to describe a shape: for a local descriptor from a preprocessed mesh and its
        eigenpairs, for a baseline from its input, for a model from the mesh as read. NaN in results of
        versions that did not measure it.
    """

    name: str
    family: str
    parameters: dict[str, Parameter]
    outcomes: tuple[QueryOutcome, ...]
    table: dict[str, list[float]]
    average: float
    equal_error_rate: float
    roc: list[list[float]]
    precision_recall: list[list[float]]
    seconds: float
    bytes_per_shape: int
    describe_seconds: float = math.nan

    def found_within(self, places: int) -> float:
        """Compute the share of the queries whose null shape is among the first matches.

        Parameters
        ----------
        places : int

        Returns
        -------
        share : float
            0 … 1.
        """
        return sum(outcome.rank <= places for outcome in self.outcomes) / max(len(self.outcomes), 1)

    def to_json(self) -> dict[str, Any]:
        """Convert to values of JSON.

        Outcomes become one list for each attribute, which saves half the file; infinite distances and
        figures that do not exist become null.
        """
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        values["outcomes"] = {
            entry.name: [_number(getattr(outcome, entry.name)) for outcome in self.outcomes]
            for entry in fields(QueryOutcome)
        }
        values["table"] = {kind: [_number(value) for value in row] for kind, row in self.table.items()}
        values["roc"] = [[_number(value) for value in point] for point in self.roc]
        values["precision_recall"] = [[_number(value) for value in point] for point in self.precision_recall]
        return {key: _number(value) for key, value in values.items()}

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> VariantResult:
        """Rebuild the result from `to_json`."""
        known = dict(values)
        outcomes = dict(known["outcomes"])
        for name in ("distance_relevant", "distance_first"):
            outcomes[name] = [math.inf if value is None else value for value in outcomes[name]]
        columns = [outcomes[entry.name] for entry in fields(QueryOutcome)]
        known["outcomes"] = tuple(QueryOutcome(*row) for row in zip(*columns, strict=True))
        known["table"] = {kind: [_or_nan(value) for value in row] for kind, row in known["table"].items()}
        known.setdefault("describe_seconds", None)
        for name in ("average", "equal_error_rate", "seconds", "describe_seconds"):
            known[name] = _or_nan(known[name])
        return cls(**known)


@dataclass(frozen=True)
class CategoryResult:
    """Scores of one variant on a labelled collection.

    Attributes
    ----------
    collection, variant : str
    scores : CategoryScores
    """

    collection: str
    variant: str
    scores: CategoryScores

    def to_json(self) -> dict[str, Any]:
        """Convert to values of JSON."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> CategoryResult:
        """Rebuild the result from `to_json`."""
        return cls(**{**values, "scores": CategoryScores(**values["scores"])})


@dataclass(frozen=True)
class Problem:
    """A problem with a shape or a variant.

    Attributes
    ----------
    shape : str
        Name of the shape, query or variant.
    kind : {"left out", "failed", "note"}
        A query that cannot be generated from its null shape is left out of all figures; one that failed
        counts as if its null shape were last; a note is any other remark.
    reason : str
    """

    shape: str
    kind: str
    reason: str


@dataclass(frozen=True)
class BenchmarkResult:
    """Result of a run.

    Attributes
    ----------
    collection : str
        Name of the ranked collection.
    counts : dict of str to int
        Numbers of shapes: ``{"database": 468, "nulls": 12, "negatives": 456, "queries": 652}``.
    version : str
        Of Shape Google.
    machine : dict of str to str or int
        Cores, versions of Python and numpy, …
    seed : int
        Seed of the transformations and of training.
    variants : tuple of VariantResult
        In the order of the tables.
    categories : tuple of CategoryResult
    date : str
        ISO, to the minute.
    problems : tuple of Problem
        Failures, omissions and remarks.
    """

    collection: str
    counts: dict[str, int]
    version: str
    machine: dict[str, str | int]
    seed: int
    variants: tuple[VariantResult, ...]
    categories: tuple[CategoryResult, ...]
    date: str = ""
    problems: tuple[Problem, ...] = ()

    @property
    def search(self) -> VariantResult | None:
        """The search of the last model, or the last of its stages that was measured."""
        models = [variant for variant in self.variants if variant.family == "model"]
        searches = [variant for variant in models if variant.parameters.get("stage") == "search"]
        return next(iter(searches[::-1] or models[::-1]), None)

    def variant(self, name: str) -> VariantResult | None:
        """Find a variant by its name."""
        return next((variant for variant in self.variants if variant.name == name), None)

    def to_json(self) -> dict[str, Any]:
        """Convert to values of JSON."""
        values: dict[str, Any] = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        values["variants"] = [variant.to_json() for variant in self.variants]
        values["categories"] = [category.to_json() for category in self.categories]
        values["problems"] = [asdict(problem) for problem in self.problems]
        return {"format": _FORMAT, **values}

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> BenchmarkResult:
        """Rebuild the result from `to_json`.

        Parameters
        ----------
        values : mapping

        Returns
        -------
        result : BenchmarkResult

        Raises
        ------
        BenchmarkError
            If this is not a benchmark's result, or one of another version.
        """
        try:
            known = dict(values)
            if known.pop("format") != _FORMAT:
                raise BenchmarkError(
                    f"the result was written by Shape Google {known.get('version')!s}, whose format this "
                    "version does not know; run the benchmark again"
                )
            known["variants"] = tuple(VariantResult.from_json(entry) for entry in known["variants"])
            known["categories"] = tuple(CategoryResult.from_json(entry) for entry in known["categories"])
            known["problems"] = tuple(Problem(**entry) for entry in known["problems"])
            return cls(**known)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise BenchmarkError(
                "this is not the result of a benchmark, or a field of it was changed by hand"
            ) from error


def save_result(result: BenchmarkResult, path: Path) -> None:
    """Write a result as JSON, completely or not at all.

    Parameters
    ----------
    result : BenchmarkResult
    path : Path

    Raises
    ------
    BenchmarkError
        If it cannot be written.
    """
    text = json.dumps(result.to_json(), ensure_ascii=False, allow_nan=False)
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        unfinished.write_text(text, encoding="utf-8")
        unfinished.replace(path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise BenchmarkError(
            f"cannot write '{path}' ({error.strerror}); make room, or name another folder with --output"
        ) from error


def load_result(path: Path) -> BenchmarkResult:
    """Read a file written by `save_result`.

    Parameters
    ----------
    path : Path

    Returns
    -------
    result : BenchmarkResult

    Raises
    ------
    BenchmarkError
        If the file cannot be read or is something else.
    """
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        return BenchmarkResult.from_json(values)
    except OSError as error:
        raise BenchmarkError(f"{str(path)!r} cannot be read ({error.strerror})") from error
    except BenchmarkError as error:
        raise BenchmarkError(f"{str(path)!r}: {error}; {_RESULT}") from error
    except ValueError as error:
        raise BenchmarkError(f"{str(path)!r} is no text in JSON; {_RESULT}") from error
