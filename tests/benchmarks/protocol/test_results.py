# SPDX-License-Identifier: MIT
"""Scores of variants, their JSON files, and the comparison of two runs."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.metrics import CategoryScores
from benchmarks.protocol.results import (
    BenchmarkResult,
    CategoryResult,
    Problem,
    VariantResult,
    compare,
    compare_queries,
    load_result,
    save_result,
)
from benchmarks.protocol.scoring import score_variant

INF = math.inf
DATABASE = ["cat0", "dog0", "chair"]


@dataclass(frozen=True)
class Query:
    name: str
    relevant: str
    transformation: str
    strength: int


QUERIES = [
    Query("cat0.noise.1", "cat0", "noise", 1),
    Query("cat0.noise.2", "cat0", "noise", 2),
    Query("dog0.holes.1", "dog0", "holes", 1),
    Query("dog0.holes.2", "dog0", "holes", 2),
]
DISTANCES = [[0.1, 0.2, 0.3], [0.2, 0.1, 0.3], [0.1, 0.1, 0.3], [INF, INF, INF]]


def variant(
    name: str = "model", family: str = "model", distances: list[list[float]] = DISTANCES
) -> VariantResult:
    return score_variant(name, family, {"bits": 256}, distances, QUERIES, DATABASE, 0.01, 32)


def result(*variants: VariantResult) -> BenchmarkResult:
    scores = CategoryScores(0.9, 0.5, 0.75, 0.8)
    return BenchmarkResult(
        collection="pets",
        counts={"database": 3, "nulls": 2, "negatives": 1, "queries": 4},
        version="0.1.0",
        machine={"cores": 2},
        seed=7,
        variants=variants or (variant(),),
        categories=(CategoryResult("pets", "model", scores),),
        date="2026-01-02T03:04",
        problems=(Problem("dog0.holes.2", "failed", "nothing is left of it"),),
    )


def test_scores_every_query() -> None:
    scored = variant()
    assert [outcome.rank for outcome in scored.outcomes] == [1, 2, 1.5, 3]
    assert [outcome.first for outcome in scored.outcomes] == ["cat0", "dog0", "dog0", ""]
    assert [outcome.failed for outcome in scored.outcomes] == [False, False, False, True]
    assert scored.outcomes[1].distance_relevant == 0.2
    assert scored.outcomes[1].distance_first == 0.1
    assert scored.table["noise"] == [100, 75, 75, 75, 75]
    assert scored.table["holes"] == pytest.approx([200 / 3, 50, 50, 50, 50])
    assert scored.average == 62.5
    assert scored.found_within(1) == 0.25
    assert scored.found_within(2) == 0.75
    assert scored.roc[-1] == [1, 1]
    assert 0 < scored.equal_error_rate < 0.5


def test_a_database_of_one_shape_has_no_curves() -> None:
    scored = score_variant("only", "bags", {}, [[0.3]], QUERIES[:1], ["cat0"], 0, 0)
    assert scored.average == 100
    assert math.isnan(scored.equal_error_rate)
    assert (scored.roc, scored.precision_recall) == ([], [])


def test_scoring_names_the_query_without_an_answer() -> None:
    with pytest.raises(
        BenchmarkError, match=r"'dog0\.holes\.1' should find 'dog0', which is not in the database"
    ):
        score_variant("v", "bags", {}, [[0.3]] * 4, QUERIES, ["cat0"], 0, 0)
    with pytest.raises(ValueError, match="distances are to 3 shapes, but the database has 2"):
        score_variant("v", "bags", {}, DISTANCES, QUERIES, ["cat0", "dog0"], 0, 0)


def test_comes_back_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "benchmark.json"
    one = result(variant("codes", "codes"), variant())
    save_result(one, path)
    again = load_result(path)
    assert again.categories == one.categories
    assert again.problems == one.problems
    for before, after in zip(one.variants, again.variants, strict=True):
        assert after.outcomes == before.outcomes
        assert after.table["holes"] == pytest.approx(before.table["holes"])
        assert replace(after, table={}, equal_error_rate=0, roc=[], precision_recall=[]) == replace(
            before, table={}, equal_error_rate=0, roc=[], precision_recall=[]
        )
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_missing_stays_missing(tmp_path: Path) -> None:
    late = [Query("cat0.noise.3", "cat0", "noise", 3)]
    scored = score_variant("v", "bags", {}, [[INF]], late, ["cat0"], 0, 0)
    save_result(result(scored), tmp_path / "benchmark.json")
    json.loads((tmp_path / "benchmark.json").read_text(), parse_constant=pytest.fail)
    again = load_result(tmp_path / "benchmark.json").variants[0]
    assert again.outcomes == scored.outcomes
    assert [math.isnan(value) for value in again.table["noise"]] == [True, True, False, False, False]
    assert math.isnan(again.equal_error_rate)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "benchmark.json"),
        ("[1]", "not the result of a benchmark"),
        ('{"model": "default"}', "not the result of a benchmark"),
        ('{"format": 99, "version": "9.0"}', "written by Shape Google 9.0"),
    ],
)
def test_a_file_of_something_else_is_refused_by_name(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "other.json"
    path.write_text(text)
    with pytest.raises(BenchmarkError, match=message) as caught:
        load_result(path)
    assert "other.json" in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match=r"none.json' cannot be read"):
        load_result(tmp_path / "none.json")


def test_damaged_values_are_refused() -> None:
    values = result().to_json()
    values["variants"][0]["outcomes"]["rank"].pop()
    with pytest.raises(BenchmarkError, match="not the result"):
        BenchmarkResult.from_json(values)


def test_the_search_is_that_of_the_last_model() -> None:
    search, other = variant("default · search"), variant("paper · search")
    search, other = (replace(entry, parameters={"stage": "search"}) for entry in (search, other))
    bags = variant("full bags")
    assert result(bags, other, bags, search, variant("codes", "codes"), bags).search is search
    assert result(variant("codes", "codes"), bags).search is bags
    assert result(variant("codes", "codes")).search is None


def test_compares_what_both_runs_have() -> None:
    better = [[0.1, 0.2, 0.3], [0.1, 0.2, 0.3], [0.1, 0.1, 0.3], [0.3, 0.1, 0.2]]
    before, after = (
        result(variant(), variant("gone")),
        result(variant("new"), variant("model", distances=better)),
    )
    changes = compare(before, after)
    assert [(change.variant, change.transformation, change.difference) for change in changes] == [
        ("model", "holes", pytest.approx(83.3333 - 50, abs=1e-3)),
        ("model", "noise", 25),
        ("model", "average", pytest.approx(91.6667 - 62.5, abs=1e-3)),
    ]
    queries = compare_queries(before.variants[0], after.variants[1])
    assert [(change.query, change.before, change.after) for change in queries] == [
        ("dog0.holes.2", 3, 1),
        ("cat0.noise.2", 2, 1),
    ]
    assert (queries[0].first_before, queries[0].first_after) == ("", "dog0")
