# SPDX-License-Identifier: MIT
"""Measure the errors of matched vertices between re-posed, re-meshed shapes.

    python -m benchmarks correspondence [--data FOLDER] [--blend-meshes FOLDER] [--json]

Four sets of pairs; the first shape of each is matched to the second:

creatures   procedural creatures in two poses, of seeds that nothing was learnt or chosen from; the second
            is subdivided or simplified. Vertex i is the same point of the body in every pose.
characters  with --blend-meshes, the posed characters of the .blend library as exported by
            `python -m benchmarks blend-meshes`: meshes with common vertices. The second is subdivided and
            then simplified.
tosca same  with --data, a pose of TOSCA and the same pose meshed by others. The truth is the nearest point.
tosca loop  three poses of a class, matched in a circle. There is no ground truth, so the error is the
            distance between a point and the point to which the circle leads back.

Errors are geodesic distances on the second shape as shares of its √area, the measure of the Princeton
protocol (Kim, Lipman, Funkhouser 2011). A pair counts as flipped if the match is nearer to the mirror image
of the truth, where the shape has one, than to the truth.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

import shapegoogle_core as sg
from benchmarks.creatures import CREATURE_KINDS, make_creature
from shapegoogle_core import Mesh, MeshError
from shapegoogle_core.descriptors.geodesics import surface_graph
from shapegoogle_core.mesh.prolongation import nearest_faces, prolongation
from shapegoogle_core.preprocessing import repair
from shapegoogle_core.preprocessing.resampling import simplify
from shapegoogle_core.preprocessing.subdivision import subdivide

__all__ = ["add_options", "run"]

Array = NDArray[np.float64]

CREATURE_VERTICES = 6000
SIZES = {"subdivided": 9000, "simplified": 3000}
SAMPLES = 1000
# Largest mean distance, as a share of √area, between a shape and its mirror image if it is symmetric.
MIRRORED = 0.02
# Least share of equal faces of meshes with common vertices: quadrilaterals may be cut along either diagonal.
SAME_FACES = 0.95


@dataclass(frozen=True)
class Pair:
    """Two shapes and the true correspondence.

    Attributes
    ----------
    group, name : str
    first, second : Mesh
    truth : (n, 3) array or None
        Points of the second shape for the vertices of the first.
    mirrored : (n, 3) array or None
        Mirror images of these points, where the second shape is symmetric.
    """

    group: str
    name: str
    first: Mesh
    second: Mesh
    truth: Array | None
    mirrored: Array | None


def remeshed(mesh: Mesh, vertices: int) -> Mesh:
    """Subdivide or simplify a mesh to about this number of vertices."""
    return subdivide(mesh, vertices) if vertices > len(mesh.vertices) else simplify(mesh, vertices)


def mirror(rest: Mesh) -> NDArray[np.int64] | None:
    """Find the mirror image of each vertex of a shape in a symmetric pose; None if it is not symmetric."""
    best: tuple[float, Any] = (np.inf, None)
    for axis in range(3):
        turned = rest.vertices.copy()
        low, high = turned[:, axis].min(), turned[:, axis].max()
        turned[:, axis] = low + high - turned[:, axis]
        distance, opposite = KDTree(rest.vertices).query(turned)
        unmoved = np.linalg.norm(rest.vertices[opposite] - rest.vertices, axis=1).mean()
        mean = float(np.mean(distance))
        if mean < best[0] and unmoved > 0:
            best = (mean, opposite)
    return best[1] if best[0] < MIRRORED * rest.area**0.5 else None


def creatures(seeds: list[int]) -> Iterator[Pair]:
    """Make creatures in two random poses, the second re-meshed."""
    for kind in CREATURE_KINDS:
        for seed in seeds:
            try:
                creature = make_creature(kind, seed, CREATURE_VERTICES)
            except MeshError as error:
                print(f"left out: {error}", file=sys.stderr)
                continue
            first, second = creature.pose(seed), creature.pose(seed + 1)
            opposite = mirror(creature.rest)
            for how, size in SIZES.items():
                yield Pair(
                    "creatures",
                    f"{kind}-{seed}, {how}",
                    first,
                    remeshed(second, size),
                    second.vertices,
                    None if opposite is None else second.vertices[opposite],
                )


def characters(folder: Path) -> Iterator[Pair]:
    """Pair meshes of the .blend library that have common vertices."""
    meshes = [sg.read_mesh(path) for path in sorted(folder.rglob("*.ply"))]
    groups: list[list[Mesh]] = []
    for mesh in meshes:
        for group in groups:
            if group[0].faces.shape == mesh.faces.shape and len(group[0].vertices) == len(mesh.vertices):
                same = (group[0].faces == mesh.faces).all(axis=1).mean()
                if same >= SAME_FACES:
                    group.append(mesh)
                    break
        else:
            groups.append([mesh])
    for group in groups:
        if len(group) > 2:
            for first, second in pairwise(group):
                finer = remeshed(remeshed(second, 6000), 3000)
                name = f"{Path(first.name).stem} to {Path(second.name).stem}"
                yield Pair("characters", name, first, finer, second.vertices, None)


def tosca_same(data: Path) -> Iterator[Pair]:
    """Pair poses of TOSCA with the same poses on other meshes."""
    for path in sorted((data / "tosca").glob("*.ply")):
        other = data / "tosca_remeshed" / path.name
        if not other.is_file():
            continue
        first, second = repair(sg.read_mesh(path)), repair(sg.read_mesh(other))
        if np.median(KDTree(second.vertices).query(first.vertices)[0]) > MIRRORED * second.area**0.5:
            continue  # another pose of the same name
        face, weights = nearest_faces(second, first.vertices)
        truth = (weights[:, :, None] * second.vertices[second.faces[face]]).sum(axis=1)
        yield Pair("tosca same", path.stem, first, second, truth, None)


def matched(first: Mesh, second: Mesh) -> tuple[Any, Array, float]:
    """Match two shapes; return the match, the images of the first one's vertices and the seconds it took."""
    started = time.perf_counter()
    match = sg.match_vertices(first, second)
    seconds = time.perf_counter() - started
    return match, (match.weights[:, :, None] * second.vertices[second.faces[match.face]]).sum(axis=1), seconds


def geodesic_errors(mesh: Mesh, found: Array, truth: Array) -> Array:
    """Compute geodesic distances between points on a mesh, as shares of its √area.

    They are shortest paths between the nearest vertices; close points use the straight distance.
    """
    tree = KDTree(mesh.vertices)
    start, end = tree.query(truth)[1], tree.query(found)[1]
    sources, place = np.unique(start, return_inverse=True)
    graph = surface_graph(mesh)
    along = dijkstra(graph, directed=False, indices=sources)[place, end]
    straight = np.linalg.norm(found - truth, axis=1)
    # The nearest vertices are not the points themselves, and separate parts have no path between them.
    close = ~np.isfinite(along) | (along <= 3 * np.linalg.norm(mesh.vertices[start] - truth, axis=1))
    errors: Array = np.where(close, straight, np.maximum(along, straight)) / float(mesh.area) ** 0.5
    return errors


def measure(pair: Pair) -> dict[str, Any]:
    """Match a pair and compare it with the truth."""
    match, found, seconds = matched(pair.first, pair.second)
    chosen = np.random.default_rng(0).permutation(len(found))[:SAMPLES]
    assert pair.truth is not None
    errors = geodesic_errors(pair.second, found[chosen], pair.truth[chosen])
    flipped = False
    if pair.mirrored is not None:
        mirrored = geodesic_errors(pair.second, found[chosen], pair.mirrored[chosen])
        flipped = bool(mirrored.mean() < errors.mean())
    return {
        "group": pair.group,
        "name": pair.name,
        "mean": float(errors.mean()),
        "median": float(np.median(errors)),
        "below_0.05": float((errors < 0.05).mean()),
        "below_0.1": float((errors < 0.1).mean()),
        "flipped": flipped,
        "mirrored_mean": float(mirrored.mean()) if pair.mirrored is not None else None,
        "symmetric": match.symmetric,
        "confidence": float(match.confidence[chosen].mean()),
        "distortion": match.distortion,
        "vertices": [len(pair.first.vertices), len(pair.second.vertices)],
        "seconds": seconds,
    }


def tosca_loops(data: Path, per_class: int) -> Iterator[dict[str, Any]]:
    """Match three poses of a class in a circle; yield the errors of the composition of the three matches."""
    poses: dict[str, list[Path]] = {}
    for path in sorted((data / "tosca_remeshed").glob("*.ply")):
        if not path.stem[0].isdigit():
            poses.setdefault(re.sub(r"\d+$", "", path.stem), []).append(path)
    for name, paths in poses.items():
        for start in range(0, min(len(paths) - 2, 3 * per_class), 3):
            circle = [repair(sg.read_mesh(path)) for path in paths[start : start + 3]]
            here, seconds, symmetric = circle[0].vertices, 0.0, False
            for first, second in zip(circle, [*circle[1:], circle[0]], strict=True):
                match, found, took = matched(first, second)
                here = prolongation(first, here) @ found
                seconds, symmetric = seconds + took, symmetric or match.symmetric
            chosen = np.random.default_rng(0).permutation(len(here))[:SAMPLES]
            errors = geodesic_errors(circle[0], here[chosen], circle[0].vertices[chosen])
            yield {
                "group": "tosca loop",
                "name": f"{name}: {', '.join(path.stem for path in paths[start : start + 3])}",
                "mean": float(errors.mean()),
                "median": float(np.median(errors)),
                "below_0.05": float((errors < 0.05).mean()),
                "below_0.1": float((errors < 0.1).mean()),
                "flipped": False,
                "symmetric": symmetric,
                "seconds": seconds,
            }


def summary(group: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Summarise a set of pairs."""
    means = np.array([row["mean"] for row in rows])
    unflipped = [row["mean"] for row in rows if not row["flipped"]]
    return {
        "group": group,
        "pairs": len(rows),
        "mean": float(means.mean()),
        "median_of_pairs": float(np.median(means)),
        "median_of_points": float(np.median([row["median"] for row in rows])),
        "below_0.1": float(np.mean([row["below_0.1"] for row in rows])),
        "pairs_below_0.05": float((means < 0.05).mean()),
        "flipped": sum(row["flipped"] for row in rows),
        "mean_unflipped": float(np.mean(unflipped)) if unflipped else None,
        "seconds": float(np.mean([row["seconds"] for row in rows])),
    }


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--seeds", type=int, nargs="*", default=[120, 121], metavar="N", help="of the creatures (120 121)"
    )
    parser.add_argument(
        "--data", type=Path, metavar="FOLDER", help="with the folders tosca and tosca_remeshed"
    )
    parser.add_argument("--blend-meshes", type=Path, metavar="FOLDER", help="exported .blend meshes")
    parser.add_argument("--loops", type=int, default=2, metavar="N", help="circles for each class of TOSCA")
    parser.add_argument("--json", action="store_true", help="print all as JSON")


def run(options: argparse.Namespace) -> int:
    """Match all pairs and print the errors of each set.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    rows: list[dict[str, Any]] = []

    def take(row: dict[str, Any]) -> None:
        rows.append(row)
        if not options.json:
            note = "  flipped" if row["flipped"] else ""
            shown = f"mean {row['mean']:.4f}  below 0.1 {row['below_0.1']:6.1%}  {row['seconds']:5.1f} s"
            print(f"{row['group']:11} {row['name']:45} {shown}{note}", flush=True)

    for pair in creatures(options.seeds):
        take(measure(pair))
    if options.blend_meshes is not None:
        for pair in characters(options.blend_meshes):
            take(measure(pair))
    if options.data is not None:
        for pair in tosca_same(options.data):
            take(measure(pair))
        for row in tosca_loops(options.data, options.loops):
            take(row)
    groups = list(dict.fromkeys(row["group"] for row in rows))
    summaries = [summary(group, [row for row in rows if row["group"] == group]) for group in groups]
    if options.json:
        print(json.dumps({"summary": summaries, "pairs": rows}, indent=1))
        return 0
    print("\nset          pairs   mean  median  below 0.1  flipped  mean of the others  seconds")
    for each in summaries:
        others = "     –" if each["mean_unflipped"] is None else f"{each['mean_unflipped']:.4f}"
        print(
            f"{each['group']:11} {each['pairs']:6} {each['mean']:.4f}  {each['median_of_pairs']:.4f}"
            f"{each['below_0.1']:10.1%} {each['flipped']:8} {others:>19} {each['seconds']:8.1f}"
        )
    return 0
