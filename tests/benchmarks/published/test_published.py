# SPDX-License-Identifier: MIT
"""Published collections: small sets laid out as PSB, SHREC'11, SHREC'07 and TOSCA are, and their measures."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.io import savemat
from sklearn.metrics import average_precision_score

from benchmarks import command
from benchmarks.errors import BenchmarkError
from benchmarks.published.classification import read_classification
from benchmarks.published.layouts import read_layout
from benchmarks.published.scores import published_scores
from shapegoogle_core.errors import MeshError

CLASSES = "PSB 1\n4 5\n\nanimal 0 0\n\ndog animal 2\n\t7\n12\n\nhorse animal 2\n103 104\nmug 0 1\n812\n"


def solid(seed: int) -> Any:
    """A box or a ball that differs from all others."""
    made = (
        trimesh.creation.icosphere(2) if seed % 2 else trimesh.creation.box((1, 2, 3)).subdivide().subdivide()
    )
    made.apply_scale([1, 1 + 0.1 * seed, 1 + 0.05 * seed])
    return made


def write(path: Path, seed: int) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    solid(seed).export(path)


@pytest.fixture
def psb(tmp_path: Path) -> Path:
    """As PSB is unpacked: db/<number / 100>/m<number>/m<number>.off, and models of no class."""
    for number in (7, 12, 103, 104, 812, 900):
        write(tmp_path / "db" / str(number // 100) / f"m{number}" / f"m{number}.off", number)
    (tmp_path / "classification").mkdir()
    (tmp_path / "classification" / "test.cla").write_text(CLASSES)
    return tmp_path


def test_a_classification_names_the_class_of_each_model(psb: Path) -> None:
    classes = read_classification(psb / "classification" / "test.cla")
    assert classes == {"7": "dog", "12": "dog", "103": "horse", "104": "horse", "812": "mug"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("OFF\n1 2 3", "does not begin"),
        ("PSB 2\n0 0", "version 2"),
        (CLASSES[:-4], "after 0 of the 1 models of the class 'mug'"),
        (CLASSES.replace("4 5", "4 6"), "announces 4 classes and 6 models, but has 4 and 5"),
        (CLASSES.replace("812", "7"), "'7' in the classes 'dog' and 'mug'"),
        (CLASSES.replace("horse animal", "horse beast"), "belongs to 'beast', which is not defined"),
        (CLASSES.replace("mug", "dog"), "the class 'dog' twice"),
        (CLASSES.replace("dog animal 2", "dog animal two"), "'two' where a number"),
        (CLASSES + "cup", "ends within the line of the class 'cup'"),
    ],
)
def test_a_faulty_classification_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "test.cla"
    path.write_text(text)
    with pytest.raises(BenchmarkError, match=message):
        read_classification(path)


def test_psb_is_read_by_its_classification(psb: Path) -> None:
    shapes = read_layout("psb", psb)
    assert [(shape.name, shape.label) for shape in shapes] == [
        ("m7", "dog"),
        ("m12", "dog"),
        ("m103", "horse"),
        ("m104", "horse"),
        ("m812", "mug"),
    ]
    assert len(shapes[0].mesh().faces) == len(solid(7).faces)


def test_psb_without_a_model_or_with_two_classifications_is_refused(psb: Path) -> None:
    (psb / "db" / "8" / "m812" / "m812.off").unlink()
    with pytest.raises(BenchmarkError, match=r"lacks models of 'test.cla': 812"):
        read_layout("psb", psb)
    (psb / "train.cla").write_text(CLASSES)
    with pytest.raises(BenchmarkError, match="2 classification files"):
        read_layout("psb", psb)


def test_shrec11_has_models_called_t(tmp_path: Path) -> None:
    for number in range(4):
        write(tmp_path / f"T{number}.off", number)
    (tmp_path / "test.cla").write_text("PSB 1\n2 4\n\nalien 0 2\n3\n0\n\nants 0 2\n1\n2\n")
    found = {shape.name: shape.label for shape in read_layout("shrec11", tmp_path)}
    assert found == {"T3": "alien", "T0": "alien", "T1": "ants", "T2": "ants"}


def test_shrec07_has_twenty_of_each_class_in_sequence(tmp_path: Path) -> None:
    for number in (1, 2, 20, 21, 40, 41):
        write(tmp_path / f"{number}.off", number)
    found = {shape.name: shape.label for shape in read_layout("shrec07", tmp_path)}
    assert found == {"1": "class 1", "2": "class 1", "20": "class 1"} | {"21": "class 2", "40": "class 2"} | {
        "41": "class 3"
    }
    write(tmp_path / "cup.off", 1)
    with pytest.raises(BenchmarkError, match=r"'cup.off' .* is not named by a number"):
        read_layout("shrec07", tmp_path)


def test_tosca_is_read_from_matlab_text_and_mesh_files(tmp_path: Path) -> None:
    ball = solid(1)
    columns = {axis: np.asarray(ball.vertices)[:, [i]] for i, axis in enumerate("XYZ")}
    (tmp_path / "mat").mkdir()
    (tmp_path / "text").mkdir()
    for name in ("cat0", "cat1", "david10"):
        savemat(tmp_path / "mat" / f"{name}.mat", {"surface": {**columns, "TRIV": ball.faces + 1}})
        np.savetxt(tmp_path / "text" / f"{name}.vert", ball.vertices)
        np.savetxt(tmp_path / "text" / f"{name}.tri", ball.faces + 1, fmt="%d")
        write(tmp_path / "off" / f"{name}.off", 1)
    for kind in ("mat", "text", "off"):
        shapes = read_layout("tosca", tmp_path / kind)
        assert [(s.name, s.label) for s in shapes] == [("cat0", "cat"), ("cat1", "cat"), ("david10", "david")]
        mesh = shapes[0].mesh()
        np.testing.assert_array_equal(mesh.faces, ball.faces)
        np.testing.assert_allclose(mesh.vertices, ball.vertices, atol=1e-6)


def test_faulty_files_of_tosca_are_named(tmp_path: Path) -> None:
    for name in ("cat0", "cat1"):
        (tmp_path / f"{name}.vert").write_text("0 0 0\n1 0 0\n0 1 0\n")
    (tmp_path / "cat0.tri").write_text("0 1 2\n")
    first, second = read_layout("tosca", tmp_path)
    with pytest.raises(MeshError, match="vertices 0 to 2, but its 3 vertices count from 1"):
        first.mesh()
    with pytest.raises(MeshError, match=r"needs its triangles in 'cat1.tri'"):
        second.mesh()
    (tmp_path / "other").mkdir()
    savemat(tmp_path / "other" / "cat0.mat", {"shape": 1})
    savemat(tmp_path / "other" / "cat1.mat", {"shape": 1})
    with pytest.raises(MeshError, match="no structure 'surface'"):
        read_layout("tosca", tmp_path / "other")[0].mesh()


def test_folders_are_classes(tmp_path: Path) -> None:
    for name in ("cats/train/1", "cats/test/2", "dogs/1"):
        write(tmp_path / f"{name}.ply", 1)
    shapes = read_layout("folders", tmp_path)
    assert [(s.name, s.label) for s in shapes] == [
        ("cats/test/2", "cats"),
        ("cats/train/1", "cats"),
        ("dogs/1", "dogs"),
    ]
    write(tmp_path / "loose.ply", 1)
    with pytest.raises(BenchmarkError, match=r"'loose.ply' is in no sub-folder"):
        read_layout("folders", tmp_path)


def test_a_collection_without_anything_to_find_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "cats" / "1.ply", 1)
    with pytest.raises(BenchmarkError, match="nothing to find"):
        read_layout("folders", tmp_path)
    with pytest.raises(BenchmarkError, match="there is no folder"):
        read_layout("folders", tmp_path / "nothing")


def test_scores_by_hand() -> None:
    # Three cats and three dogs. The first cat finds dog, cat, cat, dog, dog; all others have a perfect order.
    labels = ["cat"] * 3 + ["dog"] * 3
    distances = np.where(np.equal.outer(labels, labels), 1.0, 2.0)
    distances[0] = [0, 2, 3, 1, 4, 5]
    scores = published_scores(distances, labels)
    assert scores.category.nearest_neighbor == pytest.approx(5 / 6)
    assert scores.category.first_tier == pytest.approx((1 / 2 + 5) / 6)
    assert scores.category.second_tier == pytest.approx(1)
    # Gains at the second and third place, of at most 1 + 1 / log₂ 2.
    assert scores.category.discounted_cumulative_gain == pytest.approx((((1 + 1 / math.log2(3)) / 2) + 5) / 6)
    # Both members are among the first 32, of which only five exist: precision 2/5, recall 1.
    assert scores.e_measure == pytest.approx(2 / (5 / 2 + 1))
    assert scores.mean_average_precision == pytest.approx(((1 / 2 + 2 / 3) / 2 + 5) / 6)


def test_the_e_measure_looks_at_32_matches() -> None:
    # 41 shapes of one class and 10 others, in perfect order: precision 1, recall 32 / 40.
    labels = ["a"] * 41 + [f"other {number}" for number in range(10)]
    distances = np.where(np.equal.outer(labels, labels), 1.0, 2.0)
    assert published_scores(distances, labels).e_measure == pytest.approx(2 / (1 + 40 / 32))


def test_average_precision_is_that_of_sklearn() -> None:
    random = np.random.default_rng(1)
    labels = [str(label) for label in random.integers(0, 4, 30)]
    distances = random.random((30, 30))
    expected = []
    for row in range(30):
        others = np.arange(30) != row
        right = np.array(labels)[others] == labels[row]
        expected.append(average_precision_score(right, -distances[row, others]))
    assert published_scores(distances, labels).mean_average_precision == pytest.approx(np.mean(expected))


def test_the_command_measures_a_collection(
    psb: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cache = ["--cache", str(tmp_path / "cache"), "--model", "default", "--parts", "bags"]
    assert command.main(["published", "psb", str(psb), *cache, "--json"]) == 0
    row = json.loads(capsys.readouterr().out)
    assert (row["shapes"], row["model"], row["part"]) == (5, "default", "bags")
    assert {"NN", "FT", "ST", "E", "DCG", "mAP"} <= set(row)
    assert command.main(["published", "psb", str(psb), *cache]) == 0
    text = capsys.readouterr().out
    assert "5 shapes in 3 classes, 4 queries" in text
    assert command.main(["published", "shrec07", str(psb), *cache]) == 2
    assert "is not named by a number" in capsys.readouterr().err
