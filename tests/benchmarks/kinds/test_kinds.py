# SPDX-License-Identifier: MIT
"""Labelled sets of kinds, their cached signatures, and the scores of the parts of the search."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import trimesh

from benchmarks import command
from benchmarks.errors import BenchmarkError
from benchmarks.kinds.describing import DescribedSet, describe_set
from benchmarks.kinds.parts import PARTS, bag_distances, search_distances
from benchmarks.kinds.sets import (
    DEVELOPMENT,
    HELD_OUT,
    HELD_OUT_PACKS,
    LEARNING_PACKS,
    MEASURING,
    KindSet,
    KindShape,
    evaluation_sets,
    name_words,
    pack_sets,
    procedural_sets,
    weak_labels,
)
from benchmarks.protocol.cache import BenchmarkCache
from benchmarks.protocol.metrics import category_scores
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, load_model


def rod(length: float) -> Mesh:
    solid = trimesh.creation.cylinder(1, length)
    return Mesh(solid.vertices, solid.faces)


def ring(radius: float) -> Mesh:
    solid = trimesh.creation.torus(2, radius)
    return Mesh(solid.vertices, solid.faces)


def unreadable() -> Mesh:
    raise MeshError("'broken' has no faces")


def shape(label: str, make: Callable[[float], Mesh], size: float) -> KindShape:
    return KindShape(f"{label} {size}", label, f"{label} {size}", partial(make, size))


@pytest.fixture(scope="module")
def model() -> ShapeModel:
    return load_model()


@pytest.fixture(scope="module")
def solids() -> KindSet:
    shapes = [shape("rod", rod, size) for size in (6, 7, 8)]
    return KindSet("solids", DEVELOPMENT, (*shapes, *(shape("ring", ring, size) for size in (0.2, 0.25))))


@pytest.fixture(scope="module")
def described(solids: KindSet, model: ShapeModel, tmp_path_factory: pytest.TempPathFactory) -> DescribedSet:
    cache = BenchmarkCache(tmp_path_factory.mktemp("cache"))
    return describe_set(solids, model, "default", cache)


def test_names_are_split_into_words() -> None:
    assert name_words("Potion4HalFullblend.001") == ["potion", "hal", "fullblend"]
    assert name_words("USBStick_big") == ["usb", "stick", "big"]
    assert name_words("1234") == []


def test_weak_labels_prefer_a_word_that_is_a_whole_name() -> None:
    names = ["Bus", "SchoolBus", "TrafficCone", "TrafficLight", "Train", "Pug"]
    labels = weak_labels(names, ["public_transport"] * 5 + ["farm_animals"])
    assert labels == ["bus", "bus", "traffic", "traffic", "train", "quadruped"]


def test_packs_to_learn_from_and_packs_held_out_share_nothing(tmp_path: Path) -> None:
    assert not set(LEARNING_PACKS) & set(HELD_OUT_PACKS)
    with (tmp_path / "meshes.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["file", "pack", "shape", "pose"])
        for pack, name, pose in (
            ("dungeon", "Rock1", 0),
            ("dungeon", "Rock2", 0),
            ("dungeon", "Rock2", 1),
            ("furniture", "Chair", 0),
            ("posed_characters", "Male_Walking", 0),
        ):
            (tmp_path / f"{pack}-{name}.ply").write_bytes(name.encode())
            writer.writerow([f"{pack}-{name}.ply", pack, f"{pack}-{name}", pose])
    learnt, held_out = pack_sets(tmp_path)
    assert (learnt.use, held_out.use) == (DEVELOPMENT, HELD_OUT)
    assert learnt.labels == ["rock", "rock"]
    assert [shape.name for shape in held_out.shapes] == ["furniture-Chair"]
    assert (learnt.query_count, held_out.query_count) == (2, 0)
    with pytest.raises(BenchmarkError, match="has no meshes"):
        pack_sets(tmp_path / "elsewhere")


def test_evaluation_data_are_for_measuring_only(tmp_path: Path) -> None:
    rows = "dataset,path,class,pose\npsb,a.ply,vase,\npsb,b.ply,vase,\ntosca,c.ply,cat,0\n"
    (tmp_path / "labels.csv").write_text(rows, encoding="utf-8")
    sets = evaluation_sets(tmp_path)
    assert [(made.name, made.use, made.query_count) for made in sets] == [
        ("Princeton", MEASURING, 2),
        ("TOSCA", MEASURING, 0),
    ]


def test_procedural_sets_are_the_same_each_time() -> None:
    objects, soup, creatures, poses, people, *_ = procedural_sets(1_000)
    for made in (objects, creatures):
        assert min(map(made.labels.count, made.labels)) > 1
    assert len({shape.label for shape in people.shapes}) > 5
    everything = [shape.key for made in (objects, soup, creatures, poses, people) for shape in made.shapes]
    assert len(set(everything)) == len(everything)
    one, again = poses.shapes[0].mesh(), procedural_sets(1_000)[3].shapes[0].mesh()
    np.testing.assert_array_equal(one.vertices, again.vertices)


def test_signatures_are_kept(tmp_path: Path, model: ShapeModel) -> None:
    cache = BenchmarkCache(tmp_path)
    made = []

    def make() -> Mesh:
        made.append(1)
        return rod(5)

    one = KindSet("one", DEVELOPMENT, (KindShape("rod", "rod", "key", make),))
    first = describe_set(one, model, "default", cache)
    second = describe_set(one, model, "default", cache)
    assert len(made) == 1
    np.testing.assert_array_equal(first.signatures[0].bags, second.signatures[0].bags)
    describe_set(one, model, "default", cache, any_code=True)
    assert len(made) == 2


def test_a_shape_that_cannot_be_described_is_named(tmp_path: Path, model: ShapeModel) -> None:
    broken = KindShape("broken", "rod", "broken", unreadable)
    found = describe_set(
        KindSet("two", DEVELOPMENT, (broken, shape("rod", rod, 6))),
        model,
        "default",
        BenchmarkCache(tmp_path),
    )
    assert found.names == ["rod 6"]
    assert found.failures == {"broken": "'broken' has no faces"}


def test_distances_of_bags(described: DescribedSet, model: ShapeModel) -> None:
    distances = bag_distances(described, model)
    assert np.abs(np.diag(distances)).max() < 1e-5
    np.testing.assert_allclose(distances, distances.T, atol=1e-5)
    assert category_scores(distances, described.labels).nearest_neighbor == 1


def test_the_order_without_the_walk_is_that_of_kinds_or_closer(
    described: DescribedSet, model: ShapeModel
) -> None:
    kind, gate, measures = (PARTS[name](described, model) for name in ("kind", "gate", "measures"))
    assert kind is not None
    assert gate is not None
    assert measures is not None
    assert kind[0, 1:3].max() < kind[0, 3:].min()  # rods and rings
    assert (gate <= kind).all()
    assert (np.diag(gate) == 0).all()
    assert measures[0, 1] < measures[0, 3]
    assert PARTS["gate"](described, replace(model, ranking=None)) is None


def test_places_in_the_list_of_the_search(described: DescribedSet, model: ShapeModel) -> None:
    places = search_distances(described, model)
    np.testing.assert_array_equal(np.sort(places, axis=1), np.tile(np.arange(5), (5, 1)))
    np.testing.assert_array_equal(np.diag(places), 0)
    assert category_scores(places, described.labels).nearest_neighbor == 1


def test_the_packs_need_the_folder_of_their_meshes(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["kinds", "--sets", "packs held out"]) == 2
    assert "--blend-meshes" in capsys.readouterr().err


def test_the_command_prints_a_row_for_each_part(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], solids: KindSet
) -> None:
    rows = ["dataset,path,class,pose"]
    for solid in solids.shapes:
        mesh = solid.mesh()
        trimesh.Trimesh(mesh.vertices, mesh.faces).export(tmp_path / f"{solid.name}.ply")
        rows.append(f"psb,{solid.name}.ply,{solid.label},")
    (tmp_path / "labels.csv").write_text("\n".join(rows), encoding="utf-8")
    options = ["--data", str(tmp_path), "--cache", str(tmp_path / "cache"), "--parts", "bags", "--json"]
    assert command.main(["kinds", "--sets", "Princeton", *options]) == 0
    (record,) = map(json.loads, capsys.readouterr().out.splitlines())
    assert record == {
        "set": "Princeton",
        "use": "measuring",
        "queries": 5,
        "part": "bags",
        "NN": 100.0,
        "FT": 100.0,
        "ST": 100.0,
        "DCG": 100.0,
    }
