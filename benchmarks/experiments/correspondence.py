# SPDX-License-Identifier: MIT
"""Measure how well the vertices of re-posed, re-meshed shapes are matched.

    python3 -m benchmarks.experiments.correspondence [--data FOLDER] [--blend-meshes FOLDER] [--json]

Four sets of pairs; the first shape of each is matched to the second:

creatures   procedural ones in two poses, of seeds that nothing was learnt or chosen from; the second
            is subdivided or simplified. Vertex i is the same point of the body in every pose.
characters  with --blend-meshes, the posed characters of the .blend library as export_blend_meshes.py writes
            them: meshes that have their vertices in common. The second is subdivided and then simplified.
tosca same  with --data, a pose of TOSCA and the same pose meshed by others. The truth is what is nearest.
tosca loop  three poses of a class, matched around a circle: how far off one comes back, for want of a truth.

Errors are geodesic distances on the second shape as shares of its √area, the measure of the Princeton
protocol (Kim, Lipman, Funkhouser 2011). A pair counts as flipped if the match is nearer to the mirror image
of the truth, where the shape has one, than to the truth. Exit code 0, or 2 for wrong usage.
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
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from shapegoogle_core import Mesh

    Array = NDArray[np.float64]

CREATURE_VERTICES = 6000
SIZES = {"subdivided": 9000, "simplified": 3000}
SAMPLES = 1000
# A shape is its own mirror image if it comes this close to it, as a share of √area.
MIRRORED = 0.02
# Meshes have vertices in common if so many of the faces are the same ones: quadrangles are cut either way.
SAME_FACES = 0.95


@dataclass(frozen=True)
class Pair:
    """Two shapes and what is true about them."""

    group: str
    name: str
    first: Mesh
    second: Mesh
    truth: Array | None  # (n, 3) points of the second shape for the vertices of the first
    mirrored: Array | None


def remeshed(mesh: Mesh, vertices: int) -> Mesh:
    """Mesh a shape anew, with about so many vertices."""
    from shapegoogle_core.preprocessing.resampling import simplify, subdivide

    return subdivide(mesh, vertices) if vertices > len(mesh.vertices) else simplify(mesh, vertices)


def mirror(rest: Mesh) -> NDArray[np.int64] | None:
    """Vertex opposite to each, of a shape in a symmetric pose; None if it is not its own mirror image."""
    import numpy as np
    from scipy.spatial import KDTree

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
    """Creatures in two random poses, the second one meshed anew."""
    from benchmarks.creatures import CREATURE_KINDS, make_creature
    from shapegoogle_core import MeshError

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
    """Meshes of the .blend library that have their vertices in common."""
    import shapegoogle_core as sg

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
    """Poses of TOSCA beside the same ones of other meshes."""
    import numpy as np
    from scipy.spatial import KDTree

    import shapegoogle_core as sg
    from shapegoogle_core.mesh.prolongation import nearest_faces
    from shapegoogle_core.preprocessing import repair

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
    """Match of two shapes, where the vertices of the first are mapped to, and how long that took."""
    import shapegoogle_core as sg

    started = time.perf_counter()
    match = sg.match_vertices(first, second)
    seconds = time.perf_counter() - started
    return match, (match.weights[:, :, None] * second.vertices[second.faces[match.face]]).sum(axis=1), seconds


def geodesic_errors(mesh: Mesh, found: Array, truth: Array) -> Array:
    """Distances along a mesh between points on it, as shares of its √area.

    Between the nearest vertices, along edges and across them; the straight way where both are close.
    """
    import numpy as np
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import KDTree

    from shapegoogle_core.correspondence.surface import distance_graph

    tree = KDTree(mesh.vertices)
    start, end = tree.query(truth)[1], tree.query(found)[1]
    sources, place = np.unique(start, return_inverse=True)
    graph = distance_graph(mesh, np.empty((0, 2), np.int64), np.empty(0))
    along = dijkstra(graph, directed=False, indices=sources)[place, end]
    straight = np.linalg.norm(found - truth, axis=1)
    # Vertices are only near the points; and parts that are not joined have no way between them.
    close = ~np.isfinite(along) | (along <= 3 * np.linalg.norm(mesh.vertices[start] - truth, axis=1))
    errors: Array = np.where(close, straight, np.maximum(along, straight)) / float(mesh.area) ** 0.5
    return errors


def measure(pair: Pair) -> dict[str, Any]:
    """Match a pair and compare it with the truth."""
    import numpy as np

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
    """Three poses of a class around a circle; errors of the whole way, which has three matches in it."""
    import numpy as np

    import shapegoogle_core as sg
    from shapegoogle_core.mesh.prolongation import prolongation
    from shapegoogle_core.preprocessing import repair

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
    """Figures of a set of pairs."""
    import numpy as np

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


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="*", default=[120, 121], metavar="N")
    parser.add_argument(
        "--data", type=Path, metavar="FOLDER", help="with the folders tosca and tosca_remeshed"
    )
    parser.add_argument("--blend-meshes", type=Path, metavar="FOLDER", help="posed characters as .ply")
    parser.add_argument("--loops", type=int, default=2, metavar="N", help="circles of each class of TOSCA")
    parser.add_argument("--json", action="store_true", help="print all as JSON")
    options = parser.parse_args()
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


if __name__ == "__main__":
    sys.exit(main())
