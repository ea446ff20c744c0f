# SPDX-License-Identifier: MIT
"""Measure retrieval on the evaluation meshes, as the paper does, and write a report.

    python3 -m benchmarks.experiments.retrieval --data FOLDER [--variants all] [--output FOLDER]

FOLDER holds labels.csv and the collections that it names. The database is the null shape (the lowest pose)
of each class of TOSCA and the unrelated shapes of PSB. Queries are the next five poses of each class
(isometry), and ten transformations of each null shape in five strengths. Also measured are the remeshed
TOSCA shapes, which ask for the null shape of their class (a report of its own, in the folder "remeshed"),
all poses of TOSCA as categories, and, with --blend-meshes, the posed characters of the .blend library.

What was computed is kept: a run that was ended goes on where it was. Exit codes as `shapegoogle benchmark`.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchmarks.protocol.collection import BenchmarkShape, Collection, LabelledCollection

REPOSITORY = Path(__file__).resolve().parents[2]
POSES = 5
PARTS = ("retrieval", "categories", "remeshed")


@dataclass(frozen=True)
class Row:
    """A row of labels.csv."""

    path: Path
    label: str
    pose: int


def read_labels(data: Path) -> dict[str, list[Row]]:
    """Rows of labels.csv by collection, in the order of their poses."""
    rows: dict[str, list[Row]] = {}
    with (data / "labels.csv").open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            pose = int(row["pose"]) if row["pose"].isdigit() else -1
            rows.setdefault(row["dataset"], []).append(Row(data / row["path"], row["class"], pose))
    return {name: sorted(members, key=lambda row: (row.label, row.pose)) for name, members in rows.items()}


def database(labels: dict[str, list[Row]]) -> tuple[list[BenchmarkShape], list[BenchmarkShape]]:
    """Find the null shapes of TOSCA, the lowest pose of each class, and the unrelated shapes."""
    from benchmarks.protocol.collection import NEGATIVE, NULL, database_shape

    lowest: dict[str, Path] = {}
    for row in labels["tosca"]:
        lowest.setdefault(row.label, row.path)
    nulls = [database_shape(path, NULL) for path in lowest.values()]
    return nulls, [database_shape(row.path, NEGATIVE) for row in labels["psb"]]


def retrieval(labels: dict[str, list[Row]], seed: int) -> Collection:
    """Re-create the protocol of the paper's section 6.1."""
    from benchmarks.protocol.collection import ISOMETRY, BenchmarkShape, Collection, generated_queries

    nulls, negatives = database(labels)
    queries: list[BenchmarkShape] = []
    for null, poses in _by_null(nulls, labels["tosca"]):
        others = [row.path for row in poses if row.path != null.path][:POSES]
        queries += [
            BenchmarkShape(f"{null.name}.{ISOMETRY}.{strength}", path, null.name, ISOMETRY, strength)
            for strength, path in enumerate(others, start=1)
        ]
    queries += generated_queries(nulls, seed=seed)
    return Collection("TOSCA among PSB", (*nulls, *negatives), tuple(queries))


def remeshed(labels: dict[str, list[Row]]) -> Collection:
    """Ask with shapes of another triangulation, as isometries of strength 1."""
    from benchmarks.protocol.collection import ISOMETRY, BenchmarkShape, Collection

    nulls, negatives = database(labels)
    queries = [
        BenchmarkShape(f"{row.path.stem}.{ISOMETRY}.1", row.path, null.name, ISOMETRY, 1)
        for null, poses in _by_null(nulls, labels["tosca_remeshed"], labels["tosca"])
        for row in poses
    ]
    return Collection("remeshed TOSCA among PSB", (*nulls, *negatives), tuple(queries))


def _by_null(
    nulls: Sequence[BenchmarkShape], rows: Sequence[Row], null_rows: Sequence[Row] | None = None
) -> list[tuple[BenchmarkShape, list[Row]]]:
    """Rows of the class of each null shape."""
    classes = {row.path: row.label for row in null_rows or rows}
    return [(null, [row for row in rows if row.label == classes[null.path]]) for null in nulls]


def categories(rows: Sequence[Row], name: str) -> LabelledCollection:
    """Let every shape ask for the others of its class."""
    from benchmarks.protocol.collection import NULL, LabelledCollection, database_shape

    shapes = tuple(database_shape(row.path, NULL) for row in rows)
    return LabelledCollection(name, shapes, tuple(row.label for row in rows))


def posed_characters(folder: Path) -> list[Row]:
    """Find the posed characters among the meshes of export_blend_meshes.py."""
    table = folder / "meshes.csv"
    if not table.is_file():
        return []
    with table.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] == "posed_characters"]
    # One file of the woman is named otherwise than the rest of hers. Hairstyles are poses of nobody.
    people = {"Female": "woman", "Woman": "woman", "Male": "man"}
    return [
        Row(folder / row["file"], people[person], index)
        for index, row in enumerate(rows)
        if (person := row["shape"].removeprefix("posed_characters-").partition("_")[0]) in people
        and "_Hairstyle_" not in row["shape"]
    ]


def check_training(folder: Path, parser: argparse.ArgumentParser) -> None:
    """Refuse to learn from what is measured with."""
    if posed_characters(folder):
        parser.error(
            f"'{folder}' holds the posed characters, which measure; export the .blend files with "
            "--exclude posed_characters"
        )


def parse_arguments(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    from benchmarks.command import add_run_options

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    default = Path(os.environ.get("SHAPEGOOGLE_DATA", REPOSITORY.parent / "shared" / "data"))
    parser.add_argument(
        "--data", type=Path, default=default, metavar="FOLDER", help="with labels.csv (%(default)s)"
    )
    parser.add_argument(
        "--blend-meshes",
        type=Path,
        metavar="FOLDER",
        help="made by export_blend_meshes.py of the .blend files",
    )
    parser.add_argument(
        "--parts",
        nargs="+",
        choices=PARTS,
        default=PARTS,
        metavar="PART",
        help=f"some of {', '.join(PARTS)}; with the categories the retrieval is measured too",
    )
    add_run_options(parser)
    options = parser.parse_args(arguments)
    if not (options.data / "labels.csv").is_file():
        parser.error(f"there is no labels.csv in '{options.data}'; name the folder of the evaluation meshes")
    if options.train is not None:
        check_training(Path(options.train), parser)
    return options


def main(arguments: Sequence[str] | None = None) -> int:
    from benchmarks.command import measure
    from shapegoogle_core.errors import ShapeGoogleError
    from shapegoogle_core.processes.launching import orderly_end

    options = parse_arguments(arguments)
    labels = read_labels(options.data)
    output = Path(options.output)
    labelled = []
    if "categories" in options.parts:
        labelled.append(categories(labels["tosca"], "TOSCA"))
        people = [] if options.blend_meshes is None else posed_characters(options.blend_meshes)
        if people:
            labelled.append(categories(people, "posed characters"))
        else:
            print("the posed characters are left out: --blend-meshes names no folder that holds them")
    exit_codes = []
    try:
        with orderly_end():
            if "retrieval" in options.parts or labelled:
                collection = retrieval(labels, options.seed)
                exit_codes.append(measure(collection, labelled, options, output))
            if "remeshed" in options.parts:
                if options.compare and len(options.parts) > 1:
                    earlier = Path(options.compare).parent / "remeshed" / "benchmark.json"
                    options.compare = earlier if earlier.is_file() else None
                    if options.compare is None:
                        print(f"there is no '{earlier}' to compare the remeshed shapes with")
                exit_codes.append(measure(remeshed(labels), [], options, output / "remeshed"))
    except ShapeGoogleError as error:
        print(f"benchmark_retrieval: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("benchmark_retrieval: interrupted; run it again to go on", file=sys.stderr)
        return 130
    return max(exit_codes)


if __name__ == "__main__":
    sys.exit(main())
