# SPDX-License-Identifier: MIT
"""Collections made of the evaluation data: TOSCA, PSB and the posed characters of the .blend library."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.collection import (
    ISOMETRY,
    NEGATIVE,
    NULL,
    BenchmarkShape,
    Collection,
    LabelledCollection,
    database_shape,
    generated_queries,
)

__all__ = [
    "Row",
    "check_training",
    "labelled_collection",
    "null_and_negative_shapes",
    "posed_characters",
    "read_labels",
    "remeshed_collection",
    "retrieval_collection",
]

_POSES = 5
"""Poses of each class that are queries, one for each strength of "isometry"."""


@dataclass(frozen=True)
class Row:
    """A row of labels.csv.

    Attributes
    ----------
    path : Path
    label : str
        Class of the shape.
    pose : int
        −1 if the shape has no numbered pose.
    """

    path: Path
    label: str
    pose: int


def read_labels(data: Path) -> dict[str, list[Row]]:
    """Read labels.csv.

    Parameters
    ----------
    data : Path
        Folder of the evaluation data.

    Returns
    -------
    labels : dict of str to list of Row
        By collection, each in the order of classes and poses.

    Raises
    ------
    BenchmarkError
        If the folder has no labels.csv.
    """
    table = data / "labels.csv"
    if not table.is_file():
        raise BenchmarkError(f"'{data}' has no labels.csv; name the folder of the evaluation data")
    rows: dict[str, list[Row]] = {}
    with table.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            pose = int(row["pose"]) if row["pose"].isdigit() else -1
            rows.setdefault(row["dataset"], []).append(Row(data / row["path"], row["class"], pose))
    return {name: sorted(members, key=lambda row: (row.label, row.pose)) for name, members in rows.items()}


def null_and_negative_shapes(
    labels: dict[str, list[Row]],
) -> tuple[list[BenchmarkShape], list[BenchmarkShape]]:
    """List the database: the lowest pose of each class of TOSCA, and the shapes of PSB.

    Parameters
    ----------
    labels : dict of str to list of Row
        From `read_labels`.

    Returns
    -------
    nulls, negatives : list of BenchmarkShape
    """
    lowest: dict[str, Path] = {}
    for row in labels["tosca"]:
        lowest.setdefault(row.label, row.path)
    nulls = [database_shape(path, NULL) for path in lowest.values()]
    return nulls, [database_shape(row.path, NEGATIVE) for row in labels["psb"]]


def retrieval_collection(labels: dict[str, list[Row]], seed: int) -> Collection:
    """Re-create the protocol of the paper's section 6.1.

    Parameters
    ----------
    labels : dict of str to list of Row
        From `read_labels`.
    seed : int
        Seed of the generated queries.

    Returns
    -------
    collection : Collection
        The next five poses of each class are the queries of "isometry"; all others are generated.
    """
    nulls, negatives = null_and_negative_shapes(labels)
    queries: list[BenchmarkShape] = []
    for null, poses in _by_null(nulls, labels["tosca"]):
        others = [row.path for row in poses if row.path != null.path][:_POSES]
        queries += [
            BenchmarkShape(f"{null.name}.{ISOMETRY}.{strength}", path, null.name, ISOMETRY, strength)
            for strength, path in enumerate(others, start=1)
        ]
    queries += generated_queries(nulls, seed=seed)
    return Collection("TOSCA among PSB", (*nulls, *negatives), tuple(queries))


def remeshed_collection(labels: dict[str, list[Row]]) -> Collection:
    """Query with TOSCA shapes of another triangulation, as isometries of strength 1.

    Parameters
    ----------
    labels : dict of str to list of Row
        From `read_labels`.

    Returns
    -------
    collection : Collection
    """
    nulls, negatives = null_and_negative_shapes(labels)
    queries = [
        BenchmarkShape(f"{row.path.stem}.{ISOMETRY}.1", row.path, null.name, ISOMETRY, 1)
        for null, poses in _by_null(nulls, labels["tosca_remeshed"], labels["tosca"])
        for row in poses
    ]
    return Collection("remeshed TOSCA among PSB", (*nulls, *negatives), tuple(queries))


def _by_null(
    nulls: Sequence[BenchmarkShape], rows: Sequence[Row], null_rows: Sequence[Row] | None = None
) -> list[tuple[BenchmarkShape, list[Row]]]:
    """Pair each null shape with the rows of its class."""
    classes = {row.path: row.label for row in null_rows or rows}
    return [(null, [row for row in rows if row.label == classes[null.path]]) for null in nulls]


def labelled_collection(rows: Sequence[Row], name: str) -> LabelledCollection:
    """Make a collection in which every shape queries for the others of its class.

    Parameters
    ----------
    rows : sequence of Row
    name : str

    Returns
    -------
    collection : LabelledCollection
    """
    shapes = tuple(database_shape(row.path, NULL) for row in rows)
    return LabelledCollection(name, shapes, tuple(row.label for row in rows))


def posed_characters(folder: Path) -> list[Row]:
    """Find the posed characters among meshes exported by `python -m benchmarks blend-meshes`.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    rows : list of Row
        Labels are "man" and "woman"; empty if the folder has none.
    """
    table = folder / "meshes.csv"
    if not table.is_file():
        return []
    with table.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] == "posed_characters"]
    # One file of the woman has another prefix than the rest of hers. Hairstyles are not poses of anybody.
    people = {"Female": "woman", "Woman": "woman", "Male": "man"}
    return [
        Row(folder / row["file"], people[person], index)
        for index, row in enumerate(rows)
        if (person := row["shape"].removeprefix("posed_characters-").partition("_")[0]) in people
        and "_Hairstyle_" not in row["shape"]
    ]


def check_training(folder: Path) -> None:
    """Refuse to learn from shapes that are evaluated.

    Parameters
    ----------
    folder : Path
        Folder of training meshes.

    Raises
    ------
    BenchmarkError
        If it holds the posed characters.
    """
    if posed_characters(folder):
        raise BenchmarkError(
            f"'{folder}' holds the posed characters, which are evaluation data; export the .blend files with "
            "--exclude posed_characters"
        )
