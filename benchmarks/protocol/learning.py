# SPDX-License-Identifier: MIT
"""Training shapes of the variants: procedural creatures and, if given, a folder of meshes.

Shapes that are evaluated are never among them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchmarks.creatures import CREATURE_KINDS, Creature, make_creature
from benchmarks.protocol.cache import code_digest, content_digest, digest
from benchmarks.protocol.collection import ISOMETRY, NULL, STRENGTHS
from shapegoogle_core.indexing import find_meshes
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, bend, transform

__all__ = ["INDIVIDUALS", "VERSIONS", "CreatureVersion", "FileVersion", "training_versions"]

INDIVIDUALS = 4
"""Individuals of each kind of creature."""

VERSIONS = 3
"""Transformed versions of each shape, besides the shape itself."""

# All descriptions are independent of scale.
_KINDS = tuple(kind for kind in TRANSFORMATIONS if kind != "scale")


@dataclass(frozen=True)
class CreatureVersion:
    """One version of a creature, generated in the worker process that needs it.

    Attributes
    ----------
    creature : str
        Kind of the creature.
    individual : int
    pose : int
    transformation : str
        "null", "isometry" (a pose as it is) or one of `TRANSFORMATIONS`.
    strength, seed : int
        Of the transformation.
    """

    creature: str
    individual: int
    pose: int
    transformation: str
    strength: int
    seed: int

    @property
    def label(self) -> str:
        """Name of the shape: versions of one label are the same shape."""
        return f"{self.creature}-{self.individual}"

    @property
    def name(self) -> str:
        """Name of the version."""
        return f"{self.label}-{self.pose}.{self.transformation}.{self.strength}"

    @property
    def key(self) -> str:
        """Digest of everything the mesh is made from."""
        return digest(self.name, self.seed, code_digest(("benchmarks/creatures",)))

    def mesh(self) -> Mesh:
        """Make the mesh; raise `MeshError` if it cannot be made."""
        mesh = _creature(self.creature, self.individual).pose(self.pose)
        if self.transformation in (NULL, ISOMETRY):
            return mesh
        return transform(mesh, self.transformation, self.strength, self.seed)


@lru_cache(maxsize=2)
def _creature(kind: str, individual: int) -> Creature:
    return make_creature(kind, individual)


@dataclass(frozen=True)
class FileVersion:
    """One version of the shape of a mesh file, generated in the worker process that needs it.

    Attributes
    ----------
    path : Path
    label : str
        Name of the shape: versions of one label are the same shape.
    content : str
        Digest of the file.
    transformation : str
        "null", "bend" or one of `TRANSFORMATIONS`.
    strength, seed : int
        Of the transformation.
    """

    path: Path
    label: str
    content: str
    transformation: str
    strength: int
    seed: int

    @property
    def name(self) -> str:
        """Name of the version."""
        return f"{self.path.stem}.{self.transformation}.{self.strength}"

    @property
    def key(self) -> str:
        """Digest of everything the mesh is made from."""
        return digest(self.content, self.transformation, self.strength, self.seed)

    def mesh(self) -> Mesh:
        """Make the mesh; raise `MeshError` if it cannot be made."""
        mesh = read_mesh(self.path)
        if self.transformation == NULL:
            return mesh
        if self.transformation == "bend":
            return bend(mesh, self.seed, self.strength / 5)
        return transform(mesh, self.transformation, self.strength, self.seed)


def training_versions(
    train: str | Path | None = None, seed: int = 0, individuals: int = INDIVIDUALS
) -> tuple[CreatureVersion | FileVersion, ...]:
    """List the training shapes.

    Parameters
    ----------
    train : str or Path, optional
        Folder of additional meshes. The files of a sub-folder are one shape, and so are files whose names
        differ only in an ending such as "-pose3".
    seed : int
        Of the transformations.
    individuals : int
        Of each kind of creature.

    Returns
    -------
    versions : tuple of CreatureVersion and FileVersion
        Each shape as it is and in `VERSIONS` transformed versions: creatures in other poses, and some of the
        files bent instead.

    Raises
    ------
    MeshError
        If the folder is missing or holds no meshes.
    """
    random = np.random.default_rng(seed)

    def drawn(kinds: tuple[str, ...]) -> tuple[str, int, int]:
        return str(random.choice(kinds)), int(random.choice(STRENGTHS)), int(random.integers(2**31))

    versions: list[CreatureVersion | FileVersion] = []
    for creature in sorted(CREATURE_KINDS):
        for individual in range(individuals):
            versions.append(CreatureVersion(creature, individual, 0, NULL, 0, 0))
            versions += [
                CreatureVersion(creature, individual, pose, *drawn((*_KINDS, ISOMETRY)))
                for pose in range(1, VERSIONS + 1)
            ]
    if train is None:
        return tuple(versions)
    root = Path(train).resolve()
    shapes: dict[str, list[Path]] = {}
    for path in find_meshes([root]):
        folder = path.relative_to(root).parent.as_posix()
        label = re.sub(r"-pose\d+$", "", path.stem) if folder == "." else folder
        shapes.setdefault(label, []).append(path)
    for label, paths in shapes.items():
        versions += [FileVersion(path, label, content_digest(path), NULL, 0, 0) for path in paths]
        for _ in range(VERSIONS):
            path = paths[int(random.integers(len(paths)))]
            versions.append(FileVersion(path, label, content_digest(path), *drawn((*_KINDS, "bend"))))
    return tuple(versions)
