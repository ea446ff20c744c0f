# SPDX-License-Identifier: MIT
"""The estimate of the remaining time, on simulated runs with a simulated clock."""

from __future__ import annotations

import heapq
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core.indexing.progress.remaining import RemainingTime, describing_order, working_order
from shapegoogle_core.processes.pool import Spent

SEVERAL = {".blend"}
# Seconds that a process needs between two tasks.
PAUSE = 0.02
# Steps between two estimates.
EVERY = 7


@dataclass(frozen=True)
class File:
    """A file of a simulated run: what it costs, which nobody knows before."""

    path: Path
    size: int
    read_seconds: float
    meshes: tuple[int, ...]
    shape_seconds: tuple[float, ...]


def make_file(
    name: str, size: int, read_seconds: float, shapes: int, shape_seconds: float, seed: int = 0
) -> File:
    """A file whose shapes take 0.5 to 1.5 times as long as said, the larger ones longer."""
    factors = [random.Random(seed + shape).uniform(0.5, 1.5) for shape in range(shapes)]
    return File(
        Path(name),
        size,
        read_seconds,
        tuple(round(20_000 * factor) for factor in factors),
        tuple(shape_seconds * factor for factor in factors),
    )


def simulate(
    files: Sequence[File], jobs: int, *, slow_from: float = math.inf, start: float = 0.0
) -> list[tuple[float, float | None, int]]:
    """Run the files as the pool does; returns times, estimates and expected shapes after each step.

    From some time on, the machine is only half as fast. Processes need some seconds to start, and as many
    more for what the first description imports.
    """
    samples, others = working_order([(file.path, file.size) for file in files], SEVERAL)
    by_path = {file.path: file for file in files}
    remaining = RemainingTime([*samples, *others], jobs, SEVERAL)
    shapes: list[tuple[File, int | None]] = [(by_path[path], None) for path, _ in samples]
    waiting: list[tuple[File, int | None]] = [(by_path[path], None) for path, _ in others]
    running: list[tuple[float, int, File, int | None, float]] = []
    now, number, fresh = start, 0, jobs
    estimates = []
    while waiting or shapes or running:
        while len(running) < jobs and (queue := shapes or waiting):
            file, shape = queue.pop(0)
            seconds = file.read_seconds if shape is None else file.shape_seconds[shape]
            seconds *= 1.0 if now < slow_from else 2.0
            if shape is not None and fresh:
                fresh -= 1
                seconds += start
            number += 1
            heapq.heappush(running, (now + PAUSE + seconds, number, file, shape, seconds))
        now, _, file, shape, seconds = heapq.heappop(running)
        spent = Spent(seconds, PAUSE)
        if shape is None:
            remaining.read(file.path, file.size, spent, file.meshes, now)
            shapes += [(file, index) for index in describing_order(file.meshes)]
        else:
            remaining.described(file.path, file.size, file.meshes[shape], spent, now)
        if number % EVERY == 0 or not (waiting or shapes or running):
            estimates.append((now, remaining.seconds_left(now), remaining.shapes_expected()))
    assert remaining.shapes_done == sum(len(file.meshes) for file in files)
    assert remaining.shapes_waiting == 0
    return estimates


MIXES: dict[str, Callable[[], list[File]]] = {
    "one large .blend file and 350 small ones": lambda: [
        make_file("z.blend", 30_000_000, 12, 2000, 0.18),
        *(make_file(f"{i}.blend", 700_000 + 1000 * i, 0.15, 1, 0.25, i) for i in range(350)),
    ],
    "one large .blend file and 350 mesh files": lambda: [
        make_file("z.blend", 30_000_000, 12, 2000, 0.18),
        *(make_file(f"{i}.obj", 50_000 + 3000 * i, 0.05, 1, 0.3, i) for i in range(350)),
    ],
    "mesh files of two formats": lambda: [
        *(make_file(f"{i}.stl", 10_000 * (i + 1), 0.002 * i, 1, 0.1, i) for i in range(200)),
        *(make_file(f"{i}.obj", 100_000, 0.2, 1, 0.4, i) for i in range(200)),
    ],
    ".blend files with numbers of shapes that grow with their size": lambda: [
        make_file(f"{i}.blend", 600_000 + 20_000 * i * i, 0.3 + 0.01 * i, 1 + i * i, 0.2, i)
        for i in range(1, 40)
    ],
}


@pytest.mark.parametrize("jobs", [2, 8])
@pytest.mark.parametrize("mix", MIXES)
def test_the_estimate_is_right_within_thirty_per_cent(mix: str, jobs: int) -> None:
    estimates = simulate(MIXES[mix](), jobs)
    end = estimates[-1][0]
    errors = []
    for part in (0.1, 0.2, 0.3, 0.5, 0.7, 0.9):
        now, left, _ = next(entry for entry in estimates if entry[0] >= part * end)
        # Eight processes need longer for reading the large file alone than for a tenth of the rest.
        assert left is not None or (part, jobs) == (0.1, 8)
        errors.append(0.0 if left is None else left / (end - now) - 1)
    assert max(map(abs, errors)) < 0.3, errors


def sized(meshes: Sequence[int]) -> list[File]:
    """A .blend file whose shapes take the longer the larger they are."""
    seconds = tuple(0.1 + mesh / 250_000 for mesh in meshes)
    return [File(Path("scene.blend"), 5_000_000, 3.0, tuple(meshes), seconds)]


SCENES: dict[str, Callable[[], list[File]]] = {
    "300 shapes alike": lambda: [make_file("scene.blend", 2_000_000, 2, 300, 0.4)],
    "2,000 shapes alike": lambda: [make_file("scene.blend", 30_000_000, 12, 2000, 0.3)],
    "the largest last": lambda: sized([2_000] * 250 + [400_000] * 50),
    "the largest first": lambda: sized([400_000] * 50 + [2_000] * 250),
    "growing": lambda: sized([round(1_000 * 1000 ** (number / 299)) for number in range(300)]),
    "shuffled": lambda: sized([round(10 ** random.Random(n).uniform(3, 6)) for n in range(300)]),
}


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("scene", SCENES)
def test_the_whole_time_is_foretold_within_twenty_per_cent_from_a_quarter_on(scene: str, jobs: int) -> None:
    """With the start of the processes, which takes as long as describing some shapes."""
    estimates = simulate(SCENES[scene](), jobs, start=2.5)
    end = estimates[-1][0]
    for part in (0.25, 0.5, 0.75):
        now, left, _ = next(entry for entry in estimates if entry[0] >= part * end)
        assert left is not None
        assert abs((now + left) / end - 1) < 0.2, (part, now, left, end)


def test_a_few_of_each_size_are_described_first() -> None:
    assert describing_order([]) == []
    order = describing_order([100] * 20 + [9_000] * 3)
    assert order[:7] == [0, 20, 1, 21, 2, 22, 3]
    assert order[7:] == list(range(4, 20))


def test_a_machine_that_slows_down() -> None:
    """Somebody else uses it, too."""
    estimates = simulate(MIXES["one large .blend file and 350 mesh files"](), 2, slow_from=100)
    end = estimates[-1][0]
    for time in (200, 300, 400):
        now, left, _ = next(entry for entry in estimates if entry[0] >= time)
        assert left is not None
        assert abs(left / (end - now) - 1) < 0.2, (time, left, end - now)


def test_nothing_is_said_before_there_is_something_to_say() -> None:
    files = [(Path("a.blend"), 10**6), (Path("b.obj"), 10**5)]
    remaining = RemainingTime(files, 1, SEVERAL)
    assert remaining.seconds_left(0) is None
    remaining.read(files[1][0], files[1][1], Spent(1), [1000], 1)
    remaining.described(files[1][0], files[1][1], 1000, Spent(1), 2)
    # Nobody knows how many shapes a .blend file has.
    assert remaining.seconds_left(2) is None
    remaining.read(files[0][0], files[0][1], Spent(2), [1000] * 50, 4)
    assert remaining.shapes_waiting == 50
    assert remaining.seconds_left(4) == pytest.approx(50)


def test_a_run_that_is_silent_goes_on() -> None:
    """A shape that takes longer than all before does not say "1 s left" until it is done."""
    remaining = RemainingTime([(Path("a.obj"), 1000), (Path("b.obj"), 1000)], 1)
    remaining.read(Path("a.obj"), 1000, Spent(1), [500], 1)
    remaining.described(Path("a.obj"), 1000, 500, Spent(1), 2)
    assert remaining.seconds_left(2) == pytest.approx(2)
    assert remaining.seconds_left(3) == pytest.approx(1)
    assert remaining.seconds_left(202) == pytest.approx(100)


def test_one_slow_sample_says_little_about_its_kind() -> None:
    """The first task of a process imports modules; a hundred shapes of the same size tell what is usual."""
    remaining = RemainingTime([(Path("a.blend"), 10**6), *((Path(f"{i}.obj"), 9000) for i in range(50))], 1)
    remaining.read(Path("a.blend"), 10**6, Spent(1), [8000] * 100, 1)
    remaining.read(Path("0.obj"), 9000, Spent(0), [8000], 1)
    remaining.described(Path("0.obj"), 9000, 8000, Spent(2.0), 3)
    for index in range(100):
        remaining.described(Path("a.blend"), 10**6, 8000, Spent(0.2), 3 + 0.2 * (index + 1))
    left = remaining.seconds_left(23)
    assert left is not None
    assert 0.2 * 49 <= left < 0.7 * 49
    for number in range(1, 40):
        remaining.read(Path(f"{number}.obj"), 9000, Spent(0), [8000], 23)
        remaining.described(Path(f"{number}.obj"), 9000, 8000, Spent(1.0), 23 + number)
    # By now this kind is known to be slower.
    left = remaining.seconds_left(62)
    assert left == pytest.approx(10 * 1.0, rel=0.2)


def test_copies_take_no_time() -> None:
    files = [(Path(f"{number}.obj"), 1000) for number in range(100)]
    remaining = RemainingTime(files, 1)
    remaining.read(*files[0], Spent(2), [500], 2)
    remaining.described(*files[0], 500, Spent(2), 4)
    assert remaining.seconds_left(4) == pytest.approx(4 * 99)
    for file in files[1:50]:
        remaining.passed_over(*file)
    # As many of the others are copies, too.
    assert remaining.seconds_left(4) == pytest.approx(4)
    for file in files[50:]:
        remaining.passed_over(*file)
    assert remaining.seconds_left(4) == 0
    # A copy of a file that changed while it was read is read itself.
    remaining.read(*files[60], Spent(2), [500], 6)
    assert remaining.seconds_left(6) == pytest.approx(2)


def test_order() -> None:
    files = [(Path(name), size) for name, size in (("a.obj", 5), ("b.obj", 9), ("c.obj", 7), ("d.blend", 1))]
    files += [(Path("e.blend"), 90), (Path("f.BLEND"), 30), (Path("g.blend"), 10)]
    samples, others = working_order(files, SEVERAL)
    assert [path.name for path, _ in samples] == ["c.obj", "f.BLEND"]
    assert [path.name for path, _ in others] == ["e.blend", "g.blend", "d.blend", "a.obj", "b.obj"]
    assert working_order([]) == ([], [])


FILES = st.lists(
    st.builds(
        make_file,
        st.sampled_from(["a", "b", "c", "d"]).flatmap(
            lambda name: st.sampled_from([".obj", ".stl", ".blend"]).map(lambda suffix: name + suffix)
        ),
        st.integers(0, 10**8),
        st.floats(0, 100),
        st.integers(0, 5),
        st.floats(0, 100),
    ),
    min_size=1,
    max_size=12,
    unique_by=lambda file: file.path,
)


@settings(max_examples=40, deadline=None)
@given(FILES, st.integers(1, 8))
def test_any_run_ends_with_nothing_left(files: list[File], jobs: int) -> None:
    estimates = simulate(files, jobs)
    for _, left, expected in estimates:
        assert expected >= 0
        assert left is None or (left >= 0 and math.isfinite(left))
    assert estimates[-1][1:] == (0.0, 0)
