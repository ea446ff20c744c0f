# SPDX-License-Identifier: MIT
"""Give a model its background: unlike shapes that tell how distinctive an agreement is.

    python -m benchmarks train-background --blend-meshes FOLDER

The background has one procedural creature and one procedural object of each kind, three of each kind of
plain solids and stones, one of each family of flat-sided parts, one object of each kind as polygon soup, and
CC0 models of the packs to learn from, exported by `python -m benchmarks blend-meshes`, as far as they are not
near to what is in it already. Soup belongs there because shapes that fall into many loose polygons have
almost the same bags, whatever they are. The exponents are fitted on versions of other objects, as they are
and as soup, and of these models, and on pairs of different ones. Run it again whenever the bags of the model
have changed; the identifier of the model stays.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.flat_parts.families import FAMILIES
from benchmarks.kinds.sets import LEARNING_PACKS
from benchmarks.objects import OBJECT_KINDS, make_object, make_soup
from benchmarks.objects.kinds import solids
from benchmarks.parallel import map_in_processes
from benchmarks.training.models import SHIPPED
from shapegoogle_core.cli.arguments import number_from
from shapegoogle_core.errors import MeshError
from shapegoogle_core.library.search.query import QuerySample
from shapegoogle_core.library.search.settings import VerificationSettings
from shapegoogle_core.library.search.verify import verify_pair
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, bend, transform
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.model.training.background_learning import KnownPairs, learn_background
from shapegoogle_core.registration import PreparedSample

__all__ = ["add_options", "run"]

# Seeds of the background and of the shapes to calibrate on: neither is a training nor a development shape.
_SEED, _OTHER_SEED = 4_000, 5_000
# Libraries hold many of these, and they resemble each other, whatever they are.
_PLAIN_KINDS = {*solids.KINDS, "rock", "pebble", "heap of rocks", "crystals"}
_PLAIN_SEEDS = 3
# Models nearer than this to a shape of the background add nothing unlike.
_UNLIKE = 0.3
_RIVALS = 4


@dataclass(frozen=True)
class _Shape:
    """A shape to describe, made where it is needed: in a worker process.

    Attributes
    ----------
    group, kind : str
        "creature", "object", "soup", "part" or "model"; its kind, family or file.
    seed : int
        Of the individual; of a model 0.
    version : str
        "" for the shape as it is, "pose", "bend" or a transformation.
    strength, random : int
        Of the transformation.
    """

    group: str
    kind: str
    seed: int = 0
    version: str = ""
    strength: int = 0
    random: int = 0

    @property
    def identity(self) -> tuple[str, str, int]:
        return self.group, self.kind, self.seed

    @property
    def thing(self) -> tuple[str, int]:
        """The same for an object and for the soup made from it."""
        return self.kind, self.seed

    def make(self, folder: Path) -> Mesh:
        if self.group == "creature":
            return make_creature(self.kind, self.seed).pose(1 if self.version == "pose" else 0)
        if self.group == "part":
            return next(iter(FAMILIES[self.kind].values()))()
        if self.group == "model":
            mesh = read_mesh(folder / self.kind)
        else:
            make = make_soup if self.group == "soup" else make_object
            mesh = make(self.kind, self.seed)
        if self.version == "bend":
            return bend(mesh, self.random, self.strength / 5)
        return transform(mesh, self.version, self.strength, self.random) if self.version else mesh


def _describe(model: ShapeModel, folder: Path, shape: _Shape) -> ShapeSignature | None:
    """Describe a shape; None where nothing is left of it, such as of a cube with holes."""
    try:
        return model.describe(shape.make(folder))
    except MeshError:
        return None


def _models(folder: Path) -> list[str]:
    with (folder / "meshes.csv").open(newline="", encoding="utf-8") as file:
        return [row["file"] for row in csv.DictReader(file) if row["pack"] in LEARNING_PACKS]


def _background_shapes(files: Sequence[str]) -> list[_Shape]:
    shapes = [_Shape("creature", kind, _SEED, "pose") for kind in CREATURE_KINDS]
    for kind in OBJECT_KINDS:
        seeds = _PLAIN_SEEDS if kind in _PLAIN_KINDS else 1
        shapes += [_Shape("object", kind, _SEED + number) for number in range(seeds)]
    shapes += [_Shape("soup", kind, _SEED) for kind in OBJECT_KINDS]
    shapes += [_Shape("part", family) for family in FAMILIES]
    return shapes + [_Shape("model", file) for file in files]


def _versions(shapes: Sequence[_Shape]) -> list[_Shape]:
    random = np.random.default_rng(_OTHER_SEED)
    kinds = ["bend", *(kind for kind in TRANSFORMATIONS if kind != "scale")]
    return [
        replace(
            shape,
            version=str(random.choice(kinds)),
            strength=int(random.integers(1, 5)),
            random=int(random.integers(2**31)),
        )
        for shape in shapes
    ]


def _unlike(vectors: NDArray[np.float32], is_model: Sequence[bool]) -> NDArray[np.float32]:
    """Leave out models that are near to a shape of the background."""
    kept = [row for row, model in zip(vectors, is_model, strict=True) if not model]
    for row, model in zip(vectors, is_model, strict=True):
        if model and (1 - np.array(kept) @ row).min() > _UNLIKE:
            kept.append(row)
    return np.array(kept)


def _verified(model: ShapeModel, pair: tuple[ShapeSignature, ShapeSignature]) -> float:
    query, other = pair
    assert query.sample is not None
    assert other.sample is not None
    distance = float(model.distances(query.bags, other.bags[None])[0])
    candidate = PreparedSample(other.sample)
    return verify_pair(
        model, VerificationSettings(), QuerySample(PreparedSample(query.sample)), candidate, distance
    )[0]


def _known_pairs(model: ShapeModel, described: dict[_Shape, ShapeSignature], jobs: int) -> KnownPairs:
    """Pair each version with its shape, and each shape with the nearest of the others."""
    plain = [shape for shape in described if not shape.version]
    bags = np.stack([described[shape].bags for shape in plain])
    chosen, same = [], []
    for row, shape in enumerate(plain):
        nearest = np.argsort(model.distances(bags[row], bags))
        rivals = [plain[other] for other in nearest if plain[other].thing != shape.thing][:_RIVALS]
        chosen += [(shape, rival) for rival in rivals]
        same += [False] * len(rivals)
    known = {shape.identity: shape for shape in plain}
    for shape in described:
        if shape.version and shape.identity in known:
            chosen.append((shape, known[shape.identity]))
            same.append(True)
    pairs = [(described[first], described[second]) for first, second in chosen]
    verified = map_in_processes(partial(_verified, model), pairs, jobs, "pairs")
    return KnownPairs(
        first=model.comparable(np.stack([first.bags for first, _ in pairs])),
        second=model.comparable(np.stack([second.bags for _, second in pairs])),
        distances=np.array(
            [float(model.distances(first.bags, second.bags[None])[0]) for first, second in pairs]
        ),
        verified=np.array(verified),
        same=np.array(same),
    )


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument("--blend-meshes", type=Path, required=True, metavar="FOLDER", help="exported models")
    parser.add_argument("--model", type=Path, default=SHIPPED / "default.npz", help="(%(default)s)")
    parser.add_argument("--jobs", type=number_from(1), default=2, metavar="N", help="worker processes (2)")


def run(options: argparse.Namespace) -> int:
    """Describe the background, fit its exponents, and write the model again.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    model = load_model(options.model)
    files = _models(options.blend_meshes)
    shapes = _background_shapes(files)
    describe = partial(_describe, model, options.blend_meshes)
    signatures = map_in_processes(describe, shapes, options.jobs, "background")
    there = [(shape, found) for shape, found in zip(shapes, signatures, strict=True) if found is not None]
    vectors = model.comparable(np.stack([found.bags for _, found in there]))
    vectors = _unlike(vectors, [shape.group == "model" for shape, _ in there])
    creatures = [
        _Shape("creature", kind, _OTHER_SEED, pose) for kind in CREATURE_KINDS for pose in ("", "pose")
    ]
    others = [_Shape(group, kind, _OTHER_SEED) for group in ("object", "soup") for kind in OBJECT_KINDS]
    others += [_Shape("model", file) for file in files]
    versions = [*others, *_versions(others)]
    found = map_in_processes(describe, [*creatures, *versions], options.jobs, "versions")
    distinctive = model.comparable(
        np.stack([signature.bags for signature in found[: len(creatures)] if signature is not None])
    )
    described = {
        shape: signature
        for shape, signature in zip(versions, found[len(creatures) :], strict=True)
        if signature is not None
    }
    pairs = _known_pairs(model, described, options.jobs)
    background = learn_background(model, vectors, distinctive, pairs)
    model.with_parts(background=background).save(options.model)
    print(
        f"{options.model}: {len(vectors)} shapes, distinctive {background.distinctive}, exponents "
        f"{background.exponent} and {background.verified_exponent} from {pairs.same.sum()} pairs of one "
        f"shape and {(~pairs.same).sum()} of two"
    )
    return 0
