# SPDX-License-Identifier: MIT
"""Another program that reads files: what it answers; what happens when it crashes, hangs or is not there."""

from __future__ import annotations

import resource
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing import (
    ExternalReader,
    FileShapes,
    IndexingProgress,
    IndexReport,
    IndexSettings,
    ShapeReader,
    find_meshes,
    index_files,
    readable_suffixes,
)
from shapegoogle_core.indexing.reading.describing import ReadFunction
from shapegoogle_core.library.library import Library
from tests.core.indexing import misbehaving
from tests.core.number_reader import write_numbers

ONE_JOB = IndexSettings(jobs=1)


def read_shapes(path: Path, reader: ExternalReader | None = None) -> FileShapes:
    with ShapeReader(reader) as shapes:
        return shapes.read(path)


def test_shapes_of_a_file(reader: ExternalReader, tmp_path: Path) -> None:
    found = read_shapes(write_numbers(tmp_path, "two", "1 3 problem"), reader)
    assert [shape.object_name for shape in found.shapes] == ["x1", "x3"]
    assert [len(shape.placements) for shape in found.shapes] == [1, 1]
    assert found.problems == ["'Part' is no good"]
    low, high = (shape.mesh.vertices for shape in found.shapes)
    np.testing.assert_allclose(high - [0, 0, 5], 3 * (low - [0, 0, 5]))
    assert found.shapes[0].mesh.faces.tolist()[0] == [0, 2, 4]


def test_objects_that_share_a_mesh_are_one_shape(reader: ExternalReader, tmp_path: Path) -> None:
    (shape,) = read_shapes(write_numbers(tmp_path, "four", "shared 2 6 -1 1"), reader).shapes
    assert (shape.object_name, shape.name) == ("x2", "x2")
    assert [placement.object_name for placement in shape.placements] == ["x2", "x6", "x-1", "x1"]
    assert [placement.scale for placement in shape.placements] == pytest.approx([2, 6, 1, 1])
    assert [placement.is_mirrored for placement in shape.placements] == [False, False, True, False]
    # The octahedron is 2 × 2 × 3.
    assert shape.mesh.extents == shape.placements[0].extents == pytest.approx((4, 4, 6))
    assert shape.placements[1].extents == pytest.approx((12, 12, 18))


def test_a_mirrored_shape_is_not_inside_out(reader: ExternalReader, tmp_path: Path) -> None:
    (shape,) = read_shapes(write_numbers(tmp_path, "mirror", "-1"), reader).shapes
    corners = shape.mesh.vertices[shape.mesh.faces]
    volume = np.linalg.det(corners - [0, 0, 5]).sum() / 6
    assert volume > 0


def test_joined_parts(reader: ExternalReader, tmp_path: Path) -> None:
    (shared,) = read_shapes(write_numbers(tmp_path, "more", "shared 1 2 joined"), reader).shapes
    (shape,) = read_shapes(write_numbers(tmp_path, "parts", "1 2 joined"), reader).shapes
    np.testing.assert_array_equal(shape.mesh.vertices, shared.mesh.vertices)
    assert (shape.object_name, len(shape.mesh.vertices), len(shape.mesh.faces)) == ("", 12, 16)
    assert shape.mesh.faces.max() == 11


def test_a_program_that_crashes_is_started_again(reader: ExternalReader, tmp_path: Path) -> None:
    message = r"'bad.numbers' crashed the program, which read it \(exit code 3.*something is wrong"
    with ShapeReader(reader) as shapes:
        with pytest.raises(MeshError, match=message):
            shapes.read(write_numbers(tmp_path, "bad", "crash"))
        assert len(shapes.read(write_numbers(tmp_path, "good", "1")).shapes) == 1
        with pytest.raises(MeshError, match="the program does not like it"):
            shapes.read(write_numbers(tmp_path, "refused", "error"))


def test_a_program_that_hangs_is_killed(reader: ExternalReader, tmp_path: Path) -> None:
    slow = write_numbers(tmp_path, "slow", "hang")
    with ShapeReader(replace(reader, time_limit=0.5)) as shapes:
        for _ in range(2):  # it is started again
            with pytest.raises(MeshError, match=r"'slow\.numbers' was given up, since .* for 0\.5 s"):
                shapes.read(slow)


def test_a_program_says_how_far_it_is_and_gets_time_anew(reader: ExternalReader, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    with ShapeReader(replace(reader, time_limit=4), lambda done, total: seen.append((done, total))) as shapes:
        found = shapes.read(write_numbers(tmp_path, "large", "step1.5-a step1.5-b step1.5-c 2"))
    assert seen == [(1, 4), (2, 4), (3, 4)]
    assert [shape.object_name for shape in found.shapes] == ["x2"]


def test_the_progress_within_a_file_is_reported(
    reader: ExternalReader, library: Library, tmp_path: Path
) -> None:
    write_numbers(tmp_path / "files", "large", "step4-a 1")
    paths = find_meshes([tmp_path / "files"], suffixes=readable_suffixes(reader))
    reported: list[IndexingProgress] = []
    index_files(library, paths, ONE_JOB, status=reported.append, reader=reader)
    assert {progress.read_share for progress in reported} == {None, 0.5}
    (sentence,) = {progress.sentence() for progress in reported if progress.read_share is not None}
    assert sentence.startswith("0 of 1 file, 50% of a large file read")


def test_the_limit_of_a_run_is_that_of_the_program(
    reader: ExternalReader, library: Library, tmp_path: Path
) -> None:
    """The pool does not end the process that waits for the program."""
    write_numbers(tmp_path / "files", "large", "step2-a step2-b step2-c 1")
    write_numbers(tmp_path / "files", "slow", "hang")
    settings = IndexSettings(jobs=1, time_limit=4)
    report = index(library, tmp_path / "files", replace(reader, time_limit=None), settings)
    assert report.shapes == 1
    ((path, reason),) = report.failed
    assert path.name == "slow.numbers"
    assert "did not get on with it for 4 s" in reason


def test_a_program_that_is_not_there(tmp_path: Path) -> None:
    missing = ExternalReader(frozenset({".numbers"}), (str(tmp_path / "none"),), "the program")
    with pytest.raises(MeshError, match="the program cannot be started"):
        read_shapes(write_numbers(tmp_path, "good", "1"), missing)
    with pytest.raises(MeshError, match="is not there"):
        read_shapes(tmp_path / "gone.numbers", missing)


def test_without_a_reader(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="convert it first"):
        read_shapes(write_numbers(tmp_path, "good", "1"))
    assert ".numbers" not in readable_suffixes(None)


def test_index(reader: ExternalReader, library: Library, tmp_path: Path) -> None:
    folder = tmp_path / "files"
    write_numbers(folder, "a", "1 2")
    write_numbers(folder, "copy", "1 2")
    write_numbers(folder, "crash", "crash")
    write_numbers(folder, "empty", "")
    write_numbers(folder, "part", "1 problem")

    report = index(library, folder, reader)
    assert (report.added, report.shapes) == (3, 5)
    reasons = {path.name: reason for path, reason in report.failed}
    assert set(reasons) == {"crash.numbers", "part.numbers"}
    assert "crashed the program, which read it (exit code 3" in reasons["crash.numbers"]
    assert reasons["part.numbers"] == "'part.numbers': 1 of 2 objects failed: 'Part' is no good"
    shapes = {(Path(shape.source).stem, shape.object_name): shape for shape in library.shapes()}
    assert set(shapes) == {("a", "x1"), ("a", "x2"), ("copy", "x1"), ("copy", "x2"), ("part", "x1")}
    assert shapes["copy", "x2"].area == pytest.approx(shapes["a", "x2"].area)

    report = index(library, folder, reader)
    assert (report.added, report.unchanged, len(report.failed)) == (0, 3, 2)
    assert index(library, folder, reader, replace(ONE_JOB, reread=True)).updated == 2
    assert index(library, folder, reader, replace(ONE_JOB, retry=True)).unchanged == 3


def test_copies_keep_placements(reader: ExternalReader, library: Library, tmp_path: Path) -> None:
    folder = tmp_path / "files"
    write_numbers(folder, "a", "shared 1 2 -3")
    index(library, folder, reader)
    write_numbers(folder, "copy", "shared 1 2 -3")
    assert index(library, folder, reader).added == 1
    records = list(library.shapes())
    assert [(record.object_name, record.placement_count) for record in records] == [("x1", 3), ("x1", 3)]
    first, second = (library.placements(record.shape_id) for record in records)
    assert first == second
    assert [placement.object_name for placement in first] == ["x1", "x2", "x-3"]
    assert [record.name for record in records] == ["x1", "x1"]


def index(
    library: Library,
    folder: Path,
    reader: ExternalReader,
    settings: IndexSettings = ONE_JOB,
    read: ReadFunction = ShapeReader.iterate,
) -> IndexReport:
    paths = find_meshes([folder], suffixes=readable_suffixes(reader))
    return index_files(library, paths, settings, reader=reader, read=read)


def names(library: Library) -> list[tuple[str, str]]:
    return sorted((Path(shape.source).stem, shape.object_name) for shape in library.shapes())


def test_a_file_of_many_shapes_may_take_longer_than_one_shape(
    reader: ExternalReader, library: Library, tmp_path: Path
) -> None:
    """The limit is for each shape: together they take longer."""
    write_numbers(tmp_path / "files", "many", "1 2 3 4 5 6")
    settings = IndexSettings(jobs=1, time_limit=10)
    report = index(library, tmp_path / "files", reader, settings, misbehaving.read_then_take_two_seconds)
    assert (report.added, report.shapes, report.failed) == (1, 6, [])
    assert report.seconds > 10


def test_a_shape_that_takes_too_long_costs_only_itself(
    reader: ExternalReader, library: Library, tmp_path: Path
) -> None:
    write_numbers(tmp_path / "files", "some", "1 2 3")
    settings = IndexSettings(jobs=1, time_limit=10)
    report = index(library, tmp_path / "files", reader, settings, misbehaving.read_then_hang)
    ((path, reason),) = report.failed
    assert path.name == "some.numbers"
    assert reason.startswith("'some.numbers': 1 of 3 objects failed: 'x2' was not done after 10 s")
    assert names(library) == [("some", "x1"), ("some", "x3")]


def test_other_options_read_again(reader: ExternalReader, library: Library, tmp_path: Path) -> None:
    folder = tmp_path / "files"
    write_numbers(folder, "a", "1")
    other = replace(reader, options=(("prefix", "y"),))
    assert index(library, folder, reader).added == 1
    assert index(library, folder, other).updated == 1
    assert names(library) == [("a", "y1")]
    write_numbers(folder, "copy", "1")
    assert index(library, folder, other).added == 1
    assert names(library) == [("a", "y1"), ("copy", "y1")]
    # Only one of them is read again: the copies are still known as such.
    report = index(library, folder, reader)
    assert (report.updated, names(library)) == (2, [("a", "x1"), ("copy", "x1")])
    assert index(library, folder, reader).unchanged == 2


def test_a_failure_keeps_the_shapes_of_the_same_content(
    reader: ExternalReader, library: Library, tmp_path: Path
) -> None:
    folder = tmp_path / "files"
    path = write_numbers(folder, "a", "1 2")
    index(library, folder, reader)
    ((_, reason),) = index(
        library, folder, replace(reader, command=("gone",)), replace(ONE_JOB, reread=True)
    ).failed
    assert "the program cannot be started" in reason
    assert reason.endswith("(its shapes of an earlier run were kept)")
    ((_, reason),) = index(
        library, folder, replace(reader, environment=(("FAIL", "1"),)), replace(ONE_JOB, reread=True)
    ).failed
    assert "crashed" in reason
    assert names(library) == [("a", "x1"), ("a", "x2")]
    assert index(library, folder, reader).unchanged == 1
    # Another content is another matter.
    write_numbers(folder, "a", "crash")
    assert len(index(library, folder, reader).failed) == 1
    assert (names(library), library.sources()[str(path)].shape_count) == ([], 0)


@pytest.mark.parametrize("broken", ["gone", sys.executable])
def test_a_program_that_cannot_be_started_is_not_the_files_fault(
    reader: ExternalReader, library: Library, tmp_path: Path, broken: str
) -> None:
    write_numbers(tmp_path / "files", "a", "1")
    command = (broken,) if broken == "gone" else (broken, "-c", "raise SystemExit('a library is missing')")
    ((_, reason),) = index(library, tmp_path / "files", replace(reader, command=command)).failed
    assert "the program cannot be started" in reason
    assert broken == "gone" or "a library is missing" in reason
    # Without being asked to retry.
    assert index(library, tmp_path / "files", reader).added == 1


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux only")
def test_the_program_does_not_inherit_the_limit(
    reader: ExternalReader, library: Library, tmp_path: Path
) -> None:
    write_numbers(tmp_path / "files", "a", "1 swell")
    limited = replace(reader, memory_limit=77)
    ((_, reason),) = index(library, tmp_path / "files", limited, replace(ONE_JOB, memory_limit=1024)).failed
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    assert reason.endswith(f"limit {soft} asked 77")
