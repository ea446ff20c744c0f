# SPDX-License-Identifier: MIT
"""The whole search on real meshes; `python -m benchmarks retrieval` measures more of them."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

import pytest

import shapegoogle_core as sg


def labelled(data_folder: Path, dataset: str) -> dict[str, list[Path]]:
    """Files of each class, by pose."""
    with (data_folder / "labels.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["dataset"] == dataset]
    classes: dict[str, list[Path]] = {}
    for row in sorted(rows, key=lambda row: (len(row["pose"]), row["pose"], row["path"])):
        classes.setdefault(row["class"], []).append(data_folder / row["path"])
    return classes


@pytest.fixture(scope="module")
def library(data_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[sg.Library]:
    """The null shape of each TOSCA class among unrelated shapes."""
    with sg.Library.open(tmp_path_factory.mktemp("library") / "shapes.db") as library:
        for name, paths in labelled(data_folder, "tosca").items():
            library.add(sg.read_mesh(paths[0]), name=name)
        for path in sorted((data_folder / "psb").glob("*.ply"))[::40]:
            library.add(sg.read_mesh(path), name=path.name)
        yield library


def mean_reciprocal_ranks(library: sg.Library, queries: dict[str, Path]) -> list[float]:
    """Of the search by codes, and of the exact one."""
    ranks = []
    for name, path in queries.items():
        signature = library.model.describe(sg.read_mesh(path))
        for exact in (False, True):
            matches = library.query(signature, top=len(library), exact=exact, explain=0)
            assert len(matches) == len(library)
            ranks.append(1 / (1 + [match.name for match in matches].index(name)))
    return [sum(own) / len(own) for own in (ranks[::2], ranks[1::2])]


@pytest.mark.real_data
def test_another_pose_finds_its_null_shape(library: sg.Library, data_folder: Path) -> None:
    tosca = labelled(data_folder, "tosca")
    # Every other class here, the others below: describing a shape of 50,000 vertices takes seconds.
    queries = {name: paths[-1] for name, paths in list(tosca.items())[::2] if len(paths) > 1}
    assert min(mean_reciprocal_ranks(library, queries)) >= 0.95


@pytest.mark.real_data
def test_another_triangulation_finds_its_null_shape(library: sg.Library, data_folder: Path) -> None:
    tosca = labelled(data_folder, "tosca")
    remeshed = labelled(data_folder, "tosca_remeshed")
    queries = {name: remeshed[name][0] for name in list(tosca)[1::2] if name in remeshed}
    assert min(mean_reciprocal_ranks(library, queries)) >= 0.9
