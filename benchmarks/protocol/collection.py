# SPDX-License-Identifier: MIT
"""Collections of a benchmark: null shapes, unrelated shapes and queries (paper, section 6.1)."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.errors import BenchmarkError
from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing import find_meshes
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, transform

__all__ = [
    "ISOMETRY",
    "NEGATIVE",
    "NULL",
    "STRENGTHS",
    "BenchmarkShape",
    "Collection",
    "LabelledCollection",
    "NotMakeableError",
    "database_shape",
    "generated_queries",
    "read_collection",
    "read_labelled",
]

NULL, NEGATIVE, ISOMETRY = "null", "negative", "isometry"
STRENGTHS = (1, 2, 3, 4, 5)

# Suffix of the names of null shapes in the original data, which is removed here.
_NULL_ENDING = re.compile(r"\.null(\.0)?$")
# Largest number of wrong names in a message.
_REPORTED = 10


class NotMakeableError(MeshError):
    """A query cannot be generated from its null shape; it is left out and does not count as a failure."""


@dataclass(frozen=True)
class BenchmarkShape:
    """One mesh of a benchmark, read or generated in the worker process that needs it.

    Attributes
    ----------
    name : str
        For a shape of the database the stem of the file, such as "cat0"; for a query
        "<null>.<transformation>.<strength>" as in the original data, such as "cat0.noise.3".
    path : Path
        File of the mesh, or of the null shape it is generated from.
    relevant : str
        For a query the name of its null shape, for a shape of the database its own name.
    transformation : str
        "null" (a null shape), "negative" (unrelated), "isometry" or one of `TRANSFORMATIONS`.
    strength : int
        0 in the database, 1 … 5 for queries.
    seed : int or None
        Seed of the transformation, see `transform`; None if the file is the shape.
    """

    name: str
    path: Path
    relevant: str
    transformation: str
    strength: int
    seed: int | None = None

    def mesh(self) -> Mesh:
        """Read the mesh, or read and transform it.

        Returns
        -------
        mesh : Mesh

        Raises
        ------
        NotMakeableError
            If the transformation cannot be applied.
        MeshError
            If the file cannot be read.
        """
        mesh = read_mesh(self.path)
        if self.seed is None:
            return mesh
        try:
            return transform(mesh, self.transformation, self.strength, self.seed)
        except MeshError as error:
            raise NotMakeableError(f"{self.name!r} cannot be made: {error}") from error


@dataclass(frozen=True)
class Collection:
    """Collection for ranked retrieval: each query is a version of one null shape.

    Attributes
    ----------
    name : str
    database : tuple of BenchmarkShape
        Null shapes and unrelated shapes; names are unique.
    queries : tuple of BenchmarkShape
        Each has its null shape in the database; names are unique.

    Raises
    ------
    BenchmarkError
        If a name occurs twice or the null shape of a query is missing.
    """

    name: str
    database: tuple[BenchmarkShape, ...]
    queries: tuple[BenchmarkShape, ...]

    def __post_init__(self) -> None:
        problems = _repeated(self.database, "the database") + _repeated(self.queries, "the queries")
        nulls = {shape.name for shape in self.database if shape.transformation == NULL}
        problems += [
            f"the query '{query.path.name}' is a version of {query.relevant!r}, which is not a null shape"
            for query in self.queries
            if query.relevant not in nulls
        ]
        _refuse(self.name, problems)

    def counts(self) -> dict[str, int]:
        """Return the numbers of shapes: "database", consisting of "nulls" and "negatives", and "queries"."""
        nulls = sum(shape.transformation == NULL for shape in self.database)
        return {
            "database": len(self.database),
            "nulls": nulls,
            "negatives": len(self.database) - nulls,
            "queries": len(self.queries),
        }


@dataclass(frozen=True)
class LabelledCollection:
    """Collection in which every shape queries for the others of its class.

    Attributes
    ----------
    name : str
    shapes : tuple of BenchmarkShape
        Names are unique.
    labels : tuple of str
        Class of each.

    Raises
    ------
    BenchmarkError
        If a name occurs twice, labels and shapes differ in number, or no class has two members.
    """

    name: str
    shapes: tuple[BenchmarkShape, ...]
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        if len(self.shapes) != len(self.labels):
            raise BenchmarkError(
                f"{self.name!r} has {len(self.shapes)} shapes, but {len(self.labels)} labels"
            )
        problems = _repeated(self.shapes, "the collection")
        if max(Counter(self.labels).values(), default=0) < 2:
            problems.append("no class has two shapes, so there is nothing to find")
        _refuse(self.name, problems)


def _repeated(shapes: Sequence[BenchmarkShape], where: str) -> list[str]:
    count = Counter(shape.name for shape in shapes)
    return [
        f"the name {name!r} occurs {times} times in {where}" for name, times in count.items() if times > 1
    ]


def _refuse(name: str, problems: list[str]) -> None:
    if problems:
        shown = problems[:_REPORTED] + (
            [f"… and {len(problems) - _REPORTED} more"] if len(problems) > _REPORTED else []
        )
        raise BenchmarkError(
            f"{name!r} is not a valid collection:\n  " + "\n  ".join(shown) + "\nRename or move the files"
        )


def database_shape(path: Path, transformation: str, name: str = "") -> BenchmarkShape:
    """Make a shape of the database.

    Parameters
    ----------
    path : Path
    transformation : {"null", "negative"}
    name : str, optional
        Default: the stem of the file, without the ".null.0" of the original data.

    Returns
    -------
    shape : BenchmarkShape
    """
    name = name or _NULL_ENDING.sub("", path.stem)
    return BenchmarkShape(name, path, name, transformation, 0)


def generated_queries(
    nulls: Iterable[BenchmarkShape], transformations: Iterable[str] = TRANSFORMATIONS, seed: int = 0
) -> tuple[BenchmarkShape, ...]:
    """List queries of all strengths to generate from the null shapes.

    Parameters
    ----------
    nulls : iterable of BenchmarkShape
    transformations : iterable of str
        Some of `TRANSFORMATIONS`.
    seed : int
        Of the transformations.

    Returns
    -------
    queries : tuple of BenchmarkShape
    """
    nulls = tuple(nulls)
    return tuple(
        BenchmarkShape(f"{null.name}.{kind}.{strength}", null.path, null.name, kind, strength, seed)
        for kind in transformations
        for strength in STRENGTHS
        for null in nulls
    )


def read_collection(
    nulls: str | Path,
    negatives: str | Path | None = None,
    queries: str | Path | None = None,
    *,
    seed: int = 0,
    generate: bool = True,
) -> Collection:
    """Make a collection from folders of mesh files.

    Parameters
    ----------
    nulls : path
        Folder of the null shapes: every mesh file in it and below it. "0001.off" and "0001.null.0.off" are
        called "0001".
    negatives : path, optional
        Folder of unrelated shapes.
    queries : path, optional
        Folder of queries, named "<null>.<transformation>.<strength>.<suffix>", such as
        "0001.isometry.3.off". Names of transformations may be written without their underscore.
    seed : int
        Seed of the generated queries.
    generate : bool
        Whether to generate queries for each of `TRANSFORMATIONS` that the folder of queries lacks.

    Returns
    -------
    collection : Collection
        Named after the folder of the null shapes.

    Raises
    ------
    MeshError
        If a folder is missing or holds no meshes.
    BenchmarkError
        If names do not fit, all of which are named, or there are no queries.
    """
    name = Path(nulls).resolve().name
    wanted = [database_shape(path, NULL) for path in find_meshes([nulls])]
    unrelated = [] if negatives is None else [database_shape(p, NEGATIVE) for p in find_meshes([negatives])]
    asked: list[BenchmarkShape] = []
    if queries is not None:
        asked = _read_queries(find_meshes([queries]), name)
    if generate:
        given = {query.transformation for query in asked}
        asked += generated_queries(wanted, [kind for kind in TRANSFORMATIONS if kind not in given], seed)
    if not asked:
        raise BenchmarkError(f"{name!r} has no queries: name a folder of them, or let them be generated")
    return Collection(name, (*wanted, *unrelated), tuple(asked))


def _read_queries(paths: Sequence[Path], name: str) -> list[BenchmarkShape]:
    spelt = {kind.replace("_", ""): kind for kind in (ISOMETRY, *TRANSFORMATIONS)}
    queries, problems = [], []
    for path in paths:
        parts = path.stem.rsplit(".", 2)
        kind = spelt.get(re.sub("[_-]", "", parts[1].lower())) if len(parts) == 3 else None
        if len(parts) != 3:
            problems.append(f"'{path.name}' is not named <null>.<transformation>.<strength>{path.suffix}")
        elif kind is None:
            problems.append(f"'{path.name}': {parts[1]!r} is not one of {', '.join(spelt.values())}")
        elif not re.fullmatch("[1-5]", parts[2]):
            problems.append(f"'{path.name}': the strength must be 1 … 5, not {parts[2]!r}")
        else:
            stem, strength = parts[0], int(parts[2])
            queries.append(BenchmarkShape(f"{stem}.{kind}.{strength}", path, stem, kind, strength))
    _refuse(name, problems)
    return queries


def read_labelled(folder: str | Path) -> LabelledCollection:
    """Make a labelled collection from a folder with one sub-folder for each class.

    Parameters
    ----------
    folder : path
        Files directly in it are an error: they have no class.

    Returns
    -------
    collection : LabelledCollection
        Named after the folder; shapes are named by their path below it, without the suffix.

    Raises
    ------
    MeshError
        If the folder is missing or holds no meshes.
    BenchmarkError
        If a file has no class, or there is nothing to find.
    """
    root = Path(folder).resolve()
    paths = find_meshes([root])
    places = [path.relative_to(root) for path in paths]
    loose = [f"'{place}' is in no sub-folder, so it has no class" for place in places if len(place.parts) < 2]
    _refuse(root.name, loose)
    shapes = [
        database_shape(path, NULL, place.with_suffix("").as_posix())
        for path, place in zip(paths, places, strict=True)
    ]
    return LabelledCollection(root.name, tuple(shapes), tuple(place.parts[0] for place in places))
