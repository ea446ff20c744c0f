# SPDX-License-Identifier: MIT
"""Describing all shapes: each once, and a failure costs only its shape."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.cache import Arrays
from benchmarks.protocol.collection import BenchmarkShape, Collection
from benchmarks.protocol.workshop import Workshop, shape_key
from tests.benchmarks.benchmark_tasks import CountVertices


def counts(workshop: Workshop, task: CountVertices, collection: Collection) -> list[int | None]:
    described = workshop.describe(task, collection.database)
    return [None if entry is None else int(entry["vertices"][0]) for entry in described]


def test_each_shape_is_described_once(workshop: Workshop, collection: Collection, tmp_path: Path) -> None:
    task = CountVertices(tmp_path / "trace")
    assert counts(workshop, task, collection) == [162] * 5
    assert counts(workshop, task, collection) == [162] * 5
    assert task.calls() == ["null0", "null1", "null2", "other3", "other4"]
    counts(workshop, replace(task, key="otherwise"), collection)
    assert len(task.calls()) == 10


def test_what_fails_costs_only_itself(workshop: Workshop, collection: Collection, tmp_path: Path) -> None:
    task = CountVertices(tmp_path / "trace", fail="null1", stumble="other3")
    assert counts(workshop, task, collection) == [162, None, 162, None, 162]
    problems = {problem.shape: (problem.kind, problem.reason) for problem in workshop.problems}
    assert problems == {
        "null1": ("failed", "counting: 'null1' has no surface"),
        "other3": (
            "failed",
            "counting: 'other3' failed: a fault in Shape Google, which the traceback on stderr shows",
        ),
    }
    # What failed is tried again, and nothing else.
    assert counts(workshop, CountVertices(task.trace), collection) == [162] * 5
    assert len(task.calls()) == 7


def test_a_crash_costs_only_itself(workshop: Workshop, collection: Collection, tmp_path: Path) -> None:
    workshop.jobs = 2
    task = CountVertices(tmp_path / "trace", crash="null1")
    with workshop:
        assert counts(workshop, task, collection) == [162, None, 162, 162, 162]
    (problem,) = workshop.problems
    assert (problem.shape, problem.kind) == ("null1", "failed")
    assert "its process ended (exit code 3)" in problem.reason


def test_a_query_that_cannot_be_made_is_left_out(workshop: Workshop, tmp_path: Path, lumps: Path) -> None:
    path = tmp_path / "coarse.off"
    path.write_text("OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    query = BenchmarkShape("coarse.topology.5", path, "coarse", "topology", 5, 0)
    assert workshop.describe(CountVertices(tmp_path / "trace"), [query]) == [None]
    (problem,) = workshop.problems
    assert (problem.shape, problem.kind) == ("coarse.topology.5", "left out")
    assert "cannot be made" in problem.reason


def test_a_shape_is_known_by_content_and_what_is_done_to_it(lumps: Path, tmp_path: Path) -> None:
    path = lumps / "nulls" / "null0.off"
    copy = tmp_path / "copy.off"
    copy.write_bytes(path.read_bytes())
    shape = BenchmarkShape("null0", path, "null0", "null", 0)
    assert shape_key(shape) == shape_key(replace(shape, name="copy", path=copy, transformation="negative"))
    made = replace(shape, transformation="noise", strength=2, seed=0)
    others = [
        shape,
        made,
        replace(made, seed=1),
        replace(made, strength=3),
        replace(made, transformation="holes"),
    ]
    assert len({shape_key(other) for other in others}) == 5


def test_worker_processes_need_a_with_statement(
    workshop: Workshop, collection: Collection, tmp_path: Path
) -> None:
    workshop.jobs = 1
    with pytest.raises(ValueError, match="use the workshop in a with statement"):
        workshop.describe(CountVertices(tmp_path / "trace"), collection.database)


def fail(divisor: int) -> Arrays:
    return {"ratio": np.array(1 // divisor)}


def test_learning_that_fails_ends_the_run(workshop: Workshop) -> None:
    with pytest.raises(BenchmarkError, match="words failed: a fault in Shape Google"):
        workshop.remembered("things", fail, [0], ["00"], "words")
