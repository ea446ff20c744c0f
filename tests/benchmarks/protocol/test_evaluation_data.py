# SPDX-License-Identifier: MIT
"""The queries and databases made of the evaluation meshes."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.errors import BenchmarkError
from benchmarks.protocol import evaluation_data


@pytest.fixture
def data(tmp_path: Path) -> Path:
    rows = ["dataset,path,class,pose"]
    rows += [f"tosca,tosca/cat{pose}.ply,cat,{pose}" for pose in (10, 0, 1, 2, 3, 4, 5)]
    rows += ["tosca,tosca/shark0.ply,shark,0", "tosca,tosca/wolf1.ply,wolf,1", "tosca,tosca/wolf2.ply,wolf,2"]
    rows += ["tosca_remeshed,remeshed/cat7.ply,cat,7", "tosca_remeshed,remeshed/man1.ply,man,1"]
    rows += ["psb,psb/m1.ply,chair,"]
    (tmp_path / "labels.csv").write_text("\n".join(rows) + "\n")
    return tmp_path


def test_the_next_five_poses_ask_for_the_lowest(data: Path) -> None:
    collection = evaluation_data.retrieval_collection(evaluation_data.read_labels(data), seed=3)
    assert collection.counts() == {"database": 4, "nulls": 3, "negatives": 1, "queries": 6 + 3 * 50}
    isometries = [query for query in collection.queries if query.transformation == "isometry"]
    assert [(query.name, query.path.name) for query in isometries] == [
        ("cat0.isometry.1", "cat1.ply"),
        ("cat0.isometry.2", "cat2.ply"),
        ("cat0.isometry.3", "cat3.ply"),
        ("cat0.isometry.4", "cat4.ply"),
        ("cat0.isometry.5", "cat5.ply"),
        ("wolf1.isometry.1", "wolf2.ply"),
    ]
    assert {query.seed for query in collection.queries if query.transformation != "isometry"} == {3}


def test_remeshed_shapes_ask_for_the_null_shape_of_their_class(data: Path) -> None:
    collection = evaluation_data.remeshed_collection(evaluation_data.read_labels(data))
    (query,) = collection.queries
    assert (query.name, query.relevant, query.path.name) == ("cat7.isometry.1", "cat0", "cat7.ply")


def test_posed_characters_are_told_apart_by_their_names(tmp_path: Path) -> None:
    assert evaluation_data.posed_characters(tmp_path) == []
    pack = "posed_characters"
    names = ["Female_Walking", "Woman_Standing_Waving", "Male_Sitting", "Male_Hairstyle_1"]
    rows = [f"{pack}-{name}.ply,{pack},{pack}-{name},0" for name in names]
    rows.append("animals-Bird.ply,animals,animals-Bird,0")
    (tmp_path / "meshes.csv").write_text("\n".join(["file,pack,shape,pose", *rows]))
    people = evaluation_data.posed_characters(tmp_path)
    assert [row.label for row in people] == ["woman", "woman", "man"]


def test_a_folder_without_labels_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BenchmarkError, match=r"has no labels\.csv"):
        evaluation_data.read_labels(tmp_path)


def test_evaluation_data_is_not_learnt_from(data: Path) -> None:
    evaluation_data.check_training(data)
    (data / "meshes.csv").write_text(
        "file,pack,shape,pose\na.ply,posed_characters,posed_characters-Male_a,0\n"
    )
    with pytest.raises(BenchmarkError, match="--exclude posed_characters"):
        evaluation_data.check_training(data)


@pytest.mark.real_data
def test_what_is_asked_of_the_evaluation_meshes(data_folder: Path) -> None:
    labels = evaluation_data.read_labels(data_folder)
    collection = evaluation_data.retrieval_collection(labels, seed=0)
    assert collection.counts() == {"database": 468, "nulls": 12, "negatives": 456, "queries": 652}
    assert sum(query.transformation == "isometry" for query in collection.queries) == 52
    assert evaluation_data.remeshed_collection(labels).counts()["queries"] == 81
    assert len(evaluation_data.labelled_collection(labels["tosca"], "TOSCA").shapes) == 146
