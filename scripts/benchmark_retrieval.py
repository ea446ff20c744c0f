#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measure retrieval on the evaluation meshes: mean reciprocal rank, indexing and query times.

The database is the TOSCA null shapes (pose 0, or the lowest, of each class) and the unrelated PSB shapes;
queries are all other TOSCA poses (isometry), the same at the paper's global scales, and the remeshed
collection against the null shapes alone and against all. Every step runs through the command a user types.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import environment

REPOSITORY = Path(__file__).resolve().parent.parent
SCALES = (0.5, 0.875, 1.25, 1.625, 2.0)


def shapegoogle(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "shapegoogle_core", *map(str, arguments)]
    return subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True)


def read_labels(data: Path) -> dict[str, list[tuple[Path, str, int]]]:
    """Rows of labels.csv by dataset: path, class, pose."""
    labels: dict[str, list[tuple[Path, str, int]]] = {}
    with (data / "labels.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            pose = int(row["pose"]) if row["pose"].isdigit() else -1
            labels.setdefault(row["dataset"], []).append((data / row["path"], row["class"], pose))
    return labels


def null_shapes(tosca: Sequence[tuple[Path, str, int]]) -> dict[str, Path]:
    """Find the lowest pose of each class."""
    nulls: dict[str, tuple[int, Path]] = {}
    for path, name, pose in tosca:
        if name not in nulls or pose < nulls[name][0]:
            nulls[name] = (pose, path)
    return {name: path for name, (_, path) in nulls.items()}


def reciprocal_ranks(library: Path, queries: dict[Path, Path]) -> dict[Path, float]:
    """Ask for every query, and look where the wanted file stands."""
    answers = shapegoogle("query", *queries, "--library", library, "--top", "1000", "--json")
    ranks = {}
    for line in answers.stdout.splitlines():
        answer = json.loads(line)
        query = Path(answer["query"])
        sources = [Path(match["source"]) for match in answer["matches"]]
        wanted = queries[query].resolve()
        ranks[query] = 1 / (1 + sources.index(wanted)) if wanted in sources else 0.0
    return ranks


def index(library: Path, files: Sequence[Path], model: str, jobs: int) -> dict[str, Any]:
    started = time.monotonic()
    result = shapegoogle(
        "index", *files, "--library", library, "--model", model, "--jobs", str(jobs), "--json"
    )
    report: dict[str, Any] = json.loads(result.stdout)
    report["wall_seconds"] = time.monotonic() - started
    return report


def report(title: str, ranks: dict[Path, float], classes: dict[Path, str]) -> dict[str, Any]:
    by_class: dict[str, list[float]] = {}
    for query, rank in ranks.items():
        by_class.setdefault(classes[query], []).append(rank)
    mean = sum(ranks.values()) / len(ranks)
    first = sum(rank == 1 for rank in ranks.values()) / len(ranks)
    print(f"{title}: {len(ranks)} queries, mean reciprocal rank {mean:.4f}, first {first:.1%}")
    for name, values in sorted(by_class.items()):
        if min(values) < 1:
            print(f"    {name:10s} {sum(values) / len(values):.3f} of {len(values)}")
    for query, rank in ranks.items():
        if rank < 1:
            print(f"    {query.name} came {round(1 / rank) if rank else 'nowhere'}")
    return {"queries": len(ranks), "mean_reciprocal_rank": mean, "first": first}


def scaled_copies(nulls: dict[str, Path], folder: Path) -> dict[Path, Path]:
    import numpy as np
    import trimesh

    from shapegoogle_core.mesh import read_mesh

    queries = {}
    for name, path in nulls.items():
        mesh = read_mesh(path)
        for scale in SCALES:
            copy = folder / f"{name}-scale-{scale}.ply"
            trimesh.Trimesh(np.array(mesh.vertices) * scale, mesh.faces, process=False).export(copy)
            queries[copy] = path
    return queries


def query_seconds(library: Path, mesh_path: Path) -> float:
    """Median of one query in a running process, for a mesh brought to 5,000 vertices."""
    import statistics

    from shapegoogle_core.library import Library
    from shapegoogle_core.mesh import read_mesh
    from shapegoogle_core.mesh.resampling import resample

    mesh = resample(read_mesh(mesh_path), 5000, 5000)
    seconds = []
    with Library.open(library, read_only=True) as opened:
        opened.query(mesh)  # once for imports and the codes
        for _ in range(5):
            started = time.monotonic()
            opened.query(mesh)
            seconds.append(time.monotonic() - started)
    print(f"one query of {len(mesh.vertices)} vertices: median {statistics.median(seconds):.3f} s")
    return statistics.median(seconds)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    default = Path(os.environ.get("SHAPEGOOGLE_DATA", REPOSITORY.parent / "shared" / "data"))
    parser.add_argument("--data", type=Path, default=default, help="folder with labels.csv (%(default)s)")
    parser.add_argument("--model", default="default", help="model file or shipped name (%(default)s)")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the figures to FILE")
    arguments = parser.parse_args()
    labels = read_labels(arguments.data)
    nulls = null_shapes(labels["tosca"])
    figures: dict[str, Any] = {"model": arguments.model}
    with tempfile.TemporaryDirectory() as folder:
        everything, only_nulls = Path(folder) / "all.sglib", Path(folder) / "nulls.sglib"
        psb = [path for path, _, _ in labels["psb"]]
        made = index(everything, [*nulls.values(), *psb], arguments.model, arguments.jobs)
        count = len(nulls) + len(psb)
        print(
            f"indexed {made['added']} of {count} shapes in {made['wall_seconds']:.0f} s with "
            f"{arguments.jobs} jobs: {count / made['wall_seconds']:.2f} shapes/s"
        )
        figures["index"] = made
        index(only_nulls, list(nulls.values()), arguments.model, arguments.jobs)
        classes = {path: name for rows in labels.values() for path, name, _ in rows}
        poses = {path: nulls[name] for path, name, _ in labels["tosca"] if path != nulls[name]}
        figures["isometry"] = report("other poses", reciprocal_ranks(everything, poses), classes)
        scaled = scaled_copies(nulls, Path(folder))
        classes |= {copy: classes[original] for copy, original in scaled.items()}
        figures["scale"] = report("scaled", reciprocal_ranks(everything, scaled), classes)
        remeshed = {path: nulls[name] for path, name, _ in labels["tosca_remeshed"] if name in nulls}
        for title, library in (("remeshed, 12 nulls", only_nulls), ("remeshed, all", everything)):
            figures[title] = report(title, reciprocal_ranks(library, remeshed), classes)
        figures["query_seconds"] = query_seconds(everything, nulls["victoria"])
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=2))
    return 0


if __name__ == "__main__":
    environment.enter(("demo",))
    sys.exit(main())
