# SPDX-License-Identifier: MIT
"""Labelled sets of shapes: every shape queries for the others of its label.

Three uses are kept apart. *Development* sets are there to choose by: procedural shapes, and those CC0 packs
that may be learnt from. *Held out* are the other CC0 packs and the procedural things: they check a choice.
*Measuring* are the evaluation data, which nothing is ever chosen by.
"""

from __future__ import annotations

import csv
import re
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.creatures import CREATURE_KINDS, make_creature
from benchmarks.errors import BenchmarkError
from benchmarks.objects import OBJECT_KINDS, make_object, make_soup
from benchmarks.protocol.cache import code_digest, content_digest, digest
from benchmarks.protocol.evaluation_data import posed_characters, read_labels
from benchmarks.things import THING_KINDS, make_thing
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.model.augmentation import transform

__all__ = [
    "DEVELOPMENT",
    "HELD_OUT",
    "HELD_OUT_PACKS",
    "LEARNING_PACKS",
    "MEASURING",
    "KindSet",
    "KindShape",
    "evaluation_sets",
    "name_words",
    "pack_sets",
    "pack_shapes",
    "procedural_sets",
    "weak_labels",
]

DEVELOPMENT, HELD_OUT, MEASURING = "development", "held out", "measuring"

LEARNING_PACKS = ("animals", "dungeon", "medieval_weapons", "potions", "trees")
HELD_OUT_PACKS = ("animated_women", "farm_animals", "furniture", "public_transport")

# All models of these packs are of one kind; their names are those of individuals.
_ONE_KIND = {"animated_women": "woman", "farm_animals": "quadruped", "potions": "potion", "trees": "tree"}

# Seeds below 300 belong to the shipped models and to other development sets.
_FIRST_SEED = 300
_INDIVIDUALS, _POSES, _OBJECTS = 8, 6, 5
_THINGS_OF_A_KIND = 4
_PEOPLE, _POSES_OF_A_PERSON = 10, 6
# Without these, poses are too easily found to choose anything by.
_DAMAGES = ("local_scale", "noise", "holes", "sampling", "shot_noise")
_STRENGTH = 4


@dataclass(frozen=True)
class KindShape:
    """A labelled shape, read or made where it is needed.

    Attributes
    ----------
    name : str
        Unique within its set.
    label : str
        Shapes with the same label should find each other.
    key : str
        Digest of everything that the mesh depends on.
    mesh : callable
        Returns the mesh; importable by name, so that worker processes can call it.
    """

    name: str
    label: str
    key: str
    mesh: Callable[[], Mesh]


@dataclass(frozen=True)
class KindSet:
    """A labelled set.

    Attributes
    ----------
    name : str
    use : str
        `DEVELOPMENT`, `HELD_OUT` or `MEASURING`.
    shapes : tuple of KindShape
    """

    name: str
    use: str
    shapes: tuple[KindShape, ...]

    @property
    def labels(self) -> list[str]:
        """Label of each shape."""
        return [shape.label for shape in self.shapes]

    @property
    def query_count(self) -> int:
        """Number of shapes that share their label with another one."""
        return sum(count for count in Counter(self.labels).values() if count > 1)


def evaluation_sets(data: Path, blend_meshes: Path | None = None) -> list[KindSet]:
    """List the labelled evaluation data: kinds of Princeton models, and individuals in several poses.

    Parameters
    ----------
    data : Path
        Folder with labels.csv.
    blend_meshes : Path, optional
        Folder written by ``python -m benchmarks blend-meshes``, for the posed characters.

    Returns
    -------
    sets : list of KindSet
    """
    labels = read_labels(data)
    sets = [
        KindSet(name, MEASURING, tuple(_of_file(row.path, row.label) for row in labels[dataset]))
        for name, dataset in (("Princeton", "psb"), ("TOSCA", "tosca"), ("TOSCA remeshed", "tosca_remeshed"))
        if dataset in labels
    ]
    people = [] if blend_meshes is None else posed_characters(blend_meshes)
    if people:
        shapes = tuple(_of_file(row.path, row.label) for row in people)
        sets.append(KindSet("posed characters", MEASURING, shapes))
    return sets


def pack_sets(blend_meshes: Path) -> list[KindSet]:
    """Make weakly labelled sets of the CC0 packs: those to learn from, and those held out.

    Parameters
    ----------
    blend_meshes : Path
        Folder written by ``python -m benchmarks blend-meshes``.

    Returns
    -------
    sets : list of KindSet

    Raises
    ------
    BenchmarkError
        If the folder has no meshes.csv.
    """
    rows = _pack_rows(blend_meshes)
    sets = []
    for name, use, packs in (
        ("packs to learn from", DEVELOPMENT, LEARNING_PACKS),
        ("packs held out", HELD_OUT, HELD_OUT_PACKS),
    ):
        chosen = [row for row in rows if row["pack"] in packs]
        names = [_own_name(row) for row in chosen]
        labels = weak_labels(names, [row["pack"] for row in chosen])
        shapes = [
            _of_file(blend_meshes / row["file"], label) for row, label in zip(chosen, labels, strict=True)
        ]
        sets.append(KindSet(name, use, tuple(shapes)))
    return sets


def pack_shapes(blend_meshes: Path) -> list[KindShape]:
    """List the shapes of all packs, labelled by the pack.

    Parameters
    ----------
    blend_meshes : Path
        Folder written by ``python -m benchmarks blend-meshes``.

    Returns
    -------
    shapes : list of KindShape
        Under the names of their files, without that of the pack.

    Raises
    ------
    BenchmarkError
        If the folder has no meshes.csv.
    """
    return [
        replace(_of_file(blend_meshes / row["file"], row["pack"]), name=_own_name(row))
        for row in _pack_rows(blend_meshes)
    ]


def _pack_rows(blend_meshes: Path) -> list[dict[str, str]]:
    table = blend_meshes / "meshes.csv"
    if not table.is_file():
        raise BenchmarkError(
            f"'{blend_meshes}' has no meshes.csv; export it with `python -m benchmarks blend-meshes`"
        )
    with table.open(newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["pose"] == "0"]


def _own_name(row: Mapping[str, str]) -> str:
    return row["shape"].removeprefix(f"{row['pack']}-")


def weak_labels(names: Sequence[str], packs: Sequence[str]) -> list[str]:
    """Label shapes by the words of their names.

    The label is the first word of the name that is the whole name of a shape, as in OfficeChair where there
    is a Chair; otherwise the first word that another name has too. In packs of one kind only, such as trees,
    it is this kind.

    Parameters
    ----------
    names : sequence of n str
        Such as "Shield_Round_2".
    packs : sequence of n str
        Folder of each.

    Returns
    -------
    labels : list of n str
        The full name where nothing is shared.

    Examples
    --------
    >>> weak_labels(["Chair", "OfficeChair", "Axe_Double", "Axe_Small", "Rug"], ["furniture"] * 5)
    ['chair', 'chair', 'axe', 'axe', 'rug']
    """
    words = [name_words(name) for name in names]
    whole = {own[0] for own in words if len(own) == 1}
    frequent = Counter(word for own in words for word in set(own))
    labels = []
    for own, name, pack in zip(words, names, packs, strict=True):
        heads = [word for word in own if word in whole] or [word for word in own if frequent[word] > 1]
        labels.append(_ONE_KIND.get(pack) or (heads[0] if heads else name.lower()))
    return labels


def name_words(name: str) -> list[str]:
    """Split a name at capitals, digits and punctuation.

    Parameters
    ----------
    name : str

    Returns
    -------
    words : list of str
        In lower case, without numbers.

    Examples
    --------
    >>> name_words("ModularColumn_top2")
    ['modular', 'column', 'top']
    """
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def procedural_sets(vertices: int = 2_000) -> list[KindSet]:
    """Make sets of procedural shapes.

    Parameters
    ----------
    vertices : int, optional
        Of each creature.

    Returns
    -------
    sets : list of KindSet
        "objects": things of every kind, upright, labelled by kind.
        "soup": the same as polygon soup.
        "creatures": individuals of every kind, each in a pose of its own, labelled by kind.
        "poses": one individual of every kind in several poses, as in SHREC'11.
        "people": people in several poses, labelled by the person, as in FAUST.
        "things": everyday things of every kind, upright, held out.
        "turned things": the same with axes in any direction.
        All creatures are turned at random; poses and people are also damaged in ways of the robustness
        benchmark.
    """
    code = code_digest(("benchmarks/creatures",))

    def shapes(draws: Iterator[tuple[str, str, int, int]], damages: Sequence[str]) -> tuple[KindShape, ...]:
        return tuple(
            KindShape(
                f"{kind}-{seed}-{pose}",
                label,
                digest(code, kind, seed, pose, vertices, *([damage, _STRENGTH] if damage else [])),
                partial(_turned_creature, kind, seed, pose, vertices, damage),
            )
            for number, (label, kind, seed, pose) in enumerate(draws)
            for damage in [damages[number % len(damages)]]
        )

    seeds = range(_FIRST_SEED, _FIRST_SEED + _INDIVIDUALS)
    kinds = ((kind, kind, seed, seed) for kind in CREATURE_KINDS for seed in seeds)
    poses = ((kind, kind, _FIRST_SEED + 50, pose) for kind in CREATURE_KINDS for pose in range(_POSES))
    people = (
        (f"person {seed}", "human", _FIRST_SEED + 60 + seed, pose)
        for seed in range(_PEOPLE)
        for pose in range(_POSES_OF_A_PERSON)
    )
    return [
        KindSet("objects", DEVELOPMENT, _objects(make_object)),
        KindSet("soup", DEVELOPMENT, _objects(make_soup)),
        KindSet("creatures", DEVELOPMENT, shapes(kinds, [""])),
        KindSet("poses", DEVELOPMENT, shapes(poses, _DAMAGES)),
        KindSet("people", DEVELOPMENT, shapes(people, _DAMAGES)),
        KindSet("things", HELD_OUT, _things(turned=False)),
        KindSet("turned things", HELD_OUT, _things(turned=True)),
    ]


def _objects(make: Callable[[str, int], Mesh]) -> tuple[KindShape, ...]:
    files = ("kinds", "objects.py", "parts.py", *(["soup.py"] if make is make_soup else []))
    code = code_digest(tuple(f"benchmarks/objects/{name}" for name in files))
    return tuple(
        KindShape(f"{kind}-{seed}", kind, digest(code, kind, seed), partial(make, kind, seed))
        for kind in OBJECT_KINDS
        for seed in range(_FIRST_SEED, _FIRST_SEED + _OBJECTS)
    )


def _things(turned: bool) -> tuple[KindShape, ...]:
    code = code_digest(("benchmarks/things",))
    make = _turned_thing if turned else make_thing
    return tuple(
        KindShape(f"{kind}-{seed}", kind, digest(code, kind, seed, turned), partial(make, kind, seed))
        for kind in THING_KINDS
        for seed in range(_THINGS_OF_A_KIND)
    )


def _turned_thing(kind: str, seed: int) -> Mesh:
    mesh = make_thing(kind, seed)
    turn = Rotation.random(random_state=np.random.default_rng([zlib.crc32(kind.encode()), seed])).as_matrix()
    return Mesh(mesh.vertices @ turn.T, mesh.faces, mesh.name)


def _of_file(path: Path, label: str) -> KindShape:
    key = digest(content_digest(path), path.suffix.lower())
    return KindShape(path.stem, label, key, partial(read_mesh, path))


def _turned_creature(kind: str, seed: int, pose: int, vertices: int, damage: str) -> Mesh:
    mesh = make_creature(kind, seed, vertices).pose(pose)
    turn = Rotation.random(random_state=np.random.default_rng([seed, pose])).as_matrix()
    turned = Mesh(mesh.vertices @ turn.T, mesh.faces, mesh.name)
    return transform(turned, damage, _STRENGTH, 100 * seed + pose) if damage else turned
