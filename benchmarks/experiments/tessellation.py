# SPDX-License-Identifier: MIT
"""Describe the same surfaces cut into other triangles, and compare what comes out.

    python -m benchmarks tessellation [--blend-meshes FOLDER] [--kinds]

parts      one member of each family of flat-sided parts
plain      a box, a cylinder, a cone and a ball of few faces
creatures  procedural creatures of 1,500 vertices
packs      CC0 models, with --blend-meshes, of the packs that one may learn from

Each is cut into other triangles in several ways (`benchmarks/flat_parts/tessellations.py`). The table has,
for each shape, the area after preprocessing as a share of that of the file and its largest difference
between versions; the largest distance of bags between two versions, and their similarity; the distance to
the nearest other shape of the set, members of its family included; how many versions are nearer to the shape
than any other shape is; and with --kinds, how many of them are called the same surface.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.flat_parts import FAMILIES, make_parts
from benchmarks.flat_parts.tessellations import tessellations
from benchmarks.kinds.sets import DEVELOPMENT, pack_sets
from shapegoogle_core import Mesh, compare, load_model
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.shape_bags import shape_bags
from shapegoogle_core.model.shape_model import ShapeModel
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.preprocessing import repair
from shapegoogle_core.preprocessing.resampling import simplify

__all__ = ["add_options", "run"]

CREATURE_VERTICES = 1500
FIRST_SEED = 6_000


@dataclass(frozen=True, eq=False)
class Described:
    """Bags of a mesh, and the area that preprocessing leaves of it, as a share."""

    bags: FloatArray
    area: float


def _describe(model: ShapeModel, mesh: Mesh) -> Described:
    shape = working_shape(model.settings, mesh)
    area = shape.placement.restore(shape.mesh).area / mesh.area
    return Described(shape_bags(model.settings, model.vocabularies, shape).astype(np.float64), area)


def shape_sets(blend_meshes: Path | None, most: int) -> Iterator[tuple[str, list[tuple[str, Mesh]]]]:
    """Make or read the shapes.

    Parameters
    ----------
    blend_meshes : Path or None
        Folder of exported .blend meshes.
    most : int
        Most shapes of a set, of which versions are made.

    Yields
    ------
    name : str
        Of the set.
    shapes : list of (str, Mesh)
        In the set "parts", all members of the families; only the first of each is cut again.
    """
    yield "parts", [(f"{part.family}, {part.name}", part.mesh) for part in make_parts()]
    plain = {
        "box": trimesh.creation.box((1, 2, 3)),
        "cylinder": trimesh.creation.cylinder(1, 3, sections=24),
        "cone": trimesh.creation.cone(1, 2, sections=24),
        "ball": trimesh.creation.icosphere(subdivisions=1),
    }
    yield "plain", [(name, Mesh(shape.vertices, shape.faces, name)) for name, shape in plain.items()]
    kinds = sorted(CREATURE_KINDS)[:: max(1, len(CREATURE_KINDS) // most)]
    creatures = [(kind, make_creature(kind, FIRST_SEED).pose(0)) for kind in kinds[:most]]
    yield "creatures", [(kind, simplify(mesh, CREATURE_VERTICES)) for kind, mesh in creatures]
    if blend_meshes is not None:
        packs = [
            shape for packs in pack_sets(blend_meshes) if packs.use == DEVELOPMENT for shape in packs.shapes
        ]
        meshes = [shape.mesh() for shape in packs[:: max(1, len(packs) // most)][:most]]
        yield "packs", [(mesh.name, mesh) for mesh in meshes]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("--blend-meshes", type=Path, metavar="FOLDER", help="exported .blend meshes")
    parser.add_argument("--kinds", action="store_true", help="also name the kinds, which takes longer")
    parser.add_argument(
        "--most", type=number_from(1), default=6, metavar="N", help="creatures and CC0 models (6)"
    )


def run(options: argparse.Namespace) -> int:
    """Print the tables.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    model = load_model()
    firsts = {f"{family}, {next(iter(members))}" for family, members in FAMILIES.items()}
    for name, shapes in shape_sets(options.blend_meshes, options.most):
        described = [_describe(model, mesh) for _, mesh in shapes]
        print(f"\n{name:36s} area ±%    distance similarity  nearest other  nearer  kinds")
        for index, (shape, mesh) in enumerate(shapes):
            if name == "parts" and shape not in firsts:
                continue
            others = np.array([each.bags for number, each in enumerate(described) if number != index])
            random = np.random.default_rng(index)
            meshes = [version for _, version in tessellations(repair(mesh), random)]
            versions = [described[index], *(_describe(model, version) for version in meshes)]
            print(_row(model, shape, versions, others), end="  ")
            if options.kinds:
                kinds = Counter(_kind(model, mesh, version) for version in meshes)
                print(", ".join(f"{count} {kind}" for kind, count in kinds.most_common()), end="")
            print(flush=True)
    return 0


def _row(model: ShapeModel, name: str, versions: list[Described], others: FloatArray) -> str:
    bags = np.array([each.bags for each in versions])
    area = np.array([each.area for each in versions])
    distance = np.array([model.distances(each, bags) for each in bags])
    nearest = float(model.distances(bags[0], others).min())
    similarity = float(model.similarity(np.array([distance.max()]))[0])
    nearer = int((distance[0, 1:] < nearest).sum())
    return (
        f"{name[:36]:36s} {area[0]:.3f} {100 * np.ptp(area) / area[0]:4.2f}  {distance.max():8.4f} "
        f"{similarity:10.3f}  {nearest:13.4f}  {nearer:3d}/{len(versions) - 1}"
    )


def _kind(model: ShapeModel, mesh: Mesh, version: Mesh) -> str:
    evidence = compare(mesh, version, model=model).evidence
    return "not compared" if evidence is None else evidence.kind
