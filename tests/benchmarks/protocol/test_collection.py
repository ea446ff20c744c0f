# SPDX-License-Identifier: MIT
"""Benchmarks made of folders: names, what is generated, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.collection import (
    BenchmarkShape,
    Collection,
    LabelledCollection,
    NotMakeableError,
    database_shape,
    read_collection,
    read_labelled,
)
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, transform
from tests.benchmarks.conftest import relevant_columns


def write(path: Path, subdivisions: int = 2) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.icosphere(subdivisions).export(path)
    return path


@pytest.fixture
def nulls(tmp_path: Path) -> Path:
    write(tmp_path / "nulls" / "0001.null.0.off")
    write(tmp_path / "nulls" / "0002.off")
    return tmp_path / "nulls"


def test_queries_of_all_classes_and_strengths_are_generated(nulls: Path, tmp_path: Path) -> None:
    write(tmp_path / "others" / "chair.off")
    collection = read_collection(nulls, tmp_path / "others", seed=3)
    assert collection.name == "nulls"
    assert [shape.name for shape in collection.database] == ["0001", "0002", "chair"]
    assert [shape.transformation for shape in collection.database] == ["null", "null", "negative"]
    assert collection.counts() == {"database": 3, "nulls": 2, "negatives": 1, "queries": 100}
    assert {query.transformation for query in collection.queries} == set(TRANSFORMATIONS)
    assert {query.seed for query in collection.queries} == {3}
    assert [collection.database[column].name for column in relevant_columns(collection)] == [
        query.relevant for query in collection.queries
    ]


def test_a_generated_query_is_the_transformed_null_shape(nulls: Path) -> None:
    query = next(q for q in read_collection(nulls, seed=3).queries if q.name == "0001.noise.2")
    wanted = transform(read_mesh(nulls / "0001.null.0.off"), "noise", 2, 3)
    np.testing.assert_array_equal(query.mesh().vertices, wanted.vertices)


def test_classes_with_files_are_not_generated(nulls: Path, tmp_path: Path) -> None:
    for name in ("0001.isometry.3", "0002.shotnoise.1", "0001.local_scale.5"):
        write(tmp_path / "queries" / f"{name}.off")
    collection = read_collection(nulls, queries=tmp_path / "queries")
    files = {query.name: query for query in collection.queries if query.seed is None}
    assert sorted(files) == ["0001.isometry.3", "0001.local_scale.5", "0002.shot_noise.1"]
    assert files["0002.shot_noise.1"].relevant == "0002"
    assert files["0002.shot_noise.1"].strength == 1
    generated = {query.transformation for query in collection.queries if query.seed is not None}
    assert generated == set(TRANSFORMATIONS) - {"shot_noise", "local_scale"}
    only = read_collection(nulls, queries=tmp_path / "queries", generate=False)
    assert set(only.queries) == set(files.values())


def test_all_wrong_names_are_reported(nulls: Path, tmp_path: Path) -> None:
    for name in ("0001.off", "0001.melted.1.off", "0001.noise.6.off", "0001.noise.1.off"):
        write(tmp_path / "queries" / name)
    with pytest.raises(BenchmarkError) as caught:
        read_collection(nulls, queries=tmp_path / "queries")
    message = str(caught.value)
    assert "'0001.off' is not named <null>.<transformation>.<strength>.off" in message
    assert "'melted' is not one of isometry, noise" in message
    assert "must be 1 … 5, not '6'" in message
    assert "0001.noise.1.off" not in message


def test_names_occur_once_and_null_shapes_exist(nulls: Path, tmp_path: Path) -> None:
    write(tmp_path / "others" / "0002.obj")
    write(tmp_path / "queries" / "0003.noise.1.off")
    with pytest.raises(BenchmarkError, match="'0002' occurs 2 times in the database"):
        read_collection(nulls, tmp_path / "others")
    with pytest.raises(BenchmarkError, match=r"'0003\.noise\.1\.off' is a version of '0003'"):
        read_collection(nulls, queries=tmp_path / "queries")
    # An unrelated shape is nobody's null shape.
    negative = database_shape(Path("chair.off"), "negative")
    query = BenchmarkShape("chair.noise.1", Path("chair.off"), "chair", "noise", 1)
    with pytest.raises(BenchmarkError, match="which is not a null shape"):
        Collection("chairs", (negative,), (query,))


def test_a_missing_folder_and_no_queries(nulls: Path, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="does not exist"):
        read_collection(tmp_path / "nowhere")
    with pytest.raises(BenchmarkError, match="no queries"):
        read_collection(nulls, generate=False)


def test_a_query_that_cannot_be_made_is_told_from_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    coarse = write(tmp_path / "coarse.off", 0)
    with pytest.raises(NotMakeableError, match=r"'coarse\.topology\.5' cannot be made: .* welds 15"):
        BenchmarkShape("coarse.topology.5", coarse, "coarse", "topology", 5, 0).mesh()
    gone = tmp_path / "gone.off"
    with pytest.raises(MeshError) as caught:
        BenchmarkShape("gone.topology.5", gone, "gone", "topology", 5, 0).mesh()
    assert not isinstance(caught.value, NotMakeableError)


def test_classes_are_sub_folders(tmp_path: Path) -> None:
    for name in ("cat/one.off", "cat/two.off", "dog/one.off"):
        write(tmp_path / "animals" / name)
    collection = read_labelled(tmp_path / "animals")
    assert collection.name == "animals"
    assert [shape.name for shape in collection.shapes] == ["cat/one", "cat/two", "dog/one"]
    assert collection.labels == ("cat", "cat", "dog")
    write(tmp_path / "animals" / "stray.off")
    with pytest.raises(BenchmarkError, match=r"'stray\.off' is in no sub-folder"):
        read_labelled(tmp_path / "animals")


def test_a_labelled_collection_needs_two_of_a_class() -> None:
    shapes = tuple(database_shape(Path(f"{name}.off"), "null") for name in "ab")
    with pytest.raises(BenchmarkError, match="no class has two shapes"):
        LabelledCollection("loners", shapes, ("a", "b"))
    with pytest.raises(BenchmarkError, match="2 shapes, but 1 labels"):
        LabelledCollection("torn", shapes, ("a",))
