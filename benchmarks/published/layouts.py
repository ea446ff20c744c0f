# SPDX-License-Identifier: MIT
"""The layouts in which labelled collections are distributed."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.errors import BenchmarkError
from benchmarks.published.classification import read_classification
from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing import find_meshes
from shapegoogle_core.mesh import Mesh, read_mesh

__all__ = ["LAYOUTS", "PublishedShape", "read_layout", "read_mat_mesh", "read_vert_mesh"]

SIZE_OF_A_CLASS = 20
"""Of SHREC'07: the models 1 to 20 are the first class, 21 to 40 the second, and so on."""
# Largest number of missing models that a message names.
_NAMED = 5


@dataclass(frozen=True)
class PublishedShape:
    """A shape of a published collection.

    Attributes
    ----------
    name : str
        Of its file, without the ending.
    label : str
        Its class.
    files : tuple of Path
        All files that its content comes from.
    mesh : callable
        Reads it.
    """

    name: str
    label: str
    files: tuple[Path, ...]
    mesh: Callable[[], Mesh]


Reader = Callable[[Path, Path | None], list[PublishedShape]]


def read_layout(layout: str, folder: Path, classes: Path | None = None) -> list[PublishedShape]:
    """List the shapes of a published collection with their classes.

    Parameters
    ----------
    layout : str
        A key of `LAYOUTS`.
    folder : Path
        Where the collection was unpacked; its files may lie in sub-folders.
    classes : Path, optional
        Classification file. By default the only file of the folder that ends in ``.cla``, for layouts that
        need one.

    Returns
    -------
    shapes : list of PublishedShape

    Raises
    ------
    BenchmarkError
        If the folder does not have this layout, models are missing, or no class has two members.
    """
    if not folder.is_dir():
        raise BenchmarkError(f"there is no folder '{folder}'")
    shapes = LAYOUTS[layout](folder, classes)
    if max(Counter(shape.label for shape in shapes).values(), default=0) < 2:
        raise BenchmarkError(f"no class of '{folder}' has two shapes, so there is nothing to find")
    return shapes


def _mesh_files(folder: Path) -> list[Path]:
    try:
        return list(find_meshes([folder]))
    except MeshError as error:
        raise BenchmarkError(str(error)) from error


def _of_file(path: Path, label: str) -> PublishedShape:
    return PublishedShape(path.stem, label, (path,), partial(read_mesh, path))


def _classified(folder: Path, classes: Path | None) -> list[PublishedShape]:
    """Read PSB and SHREC'11: a classification file, and models whose names end in their identifiers."""
    table = classes or _only_classification(folder)
    by_stem: dict[str, list[Path]] = defaultdict(list)
    by_number: dict[str, list[Path]] = defaultdict(list)
    for path in _mesh_files(folder):
        by_stem[path.stem].append(path)
        if number := re.fullmatch(r"[A-Za-z_]*0*(\d+)", path.stem):
            by_number[number[1]].append(path)
    shapes, missing = [], []
    for model, label in read_classification(table).items():
        found = by_stem.get(model) or (by_number.get(str(int(model))) if model.isdecimal() else None)
        if not found:
            missing.append(model)
        elif len(found) > 1:
            raise BenchmarkError(
                f"the model {model!r} of '{table.name}' may be '{found[0]}' or '{found[1]}'; keep one of them"
            )
        else:
            shapes.append(_of_file(found[0], label))
    if missing:
        more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
        raise BenchmarkError(
            f"'{folder}' lacks models of '{table.name}': {', '.join(missing[:_NAMED])}{more}"
        )
    return shapes


def _only_classification(folder: Path) -> Path:
    found = sorted(folder.rglob("*.cla"))
    if len(found) != 1:
        what = "no classification file" if not found else f"{len(found)} classification files"
        raise BenchmarkError(f"'{folder}' has {what} (.cla); name one with --classes")
    return found[0]


def _numbered(folder: Path, classes: Path | None) -> list[PublishedShape]:
    """Read SHREC'07: files named by numbers from 1, twenty of each class in sequence."""
    if classes is not None:
        return _classified(folder, classes)
    shapes, other = [], []
    for path in _mesh_files(folder):
        if path.stem.isdecimal() and int(path.stem) >= 1:
            shapes.append((int(path.stem), path))
        else:
            other.append(path)
    if other:
        raise BenchmarkError(
            f"'{other[0].name}' in '{folder}' is not named by a number from 1, as the models of SHREC'07 are"
        )
    return [_of_file(path, f"class {1 + (number - 1) // SIZE_OF_A_CLASS}") for number, path in sorted(shapes)]


def _by_name(folder: Path, classes: Path | None) -> list[PublishedShape]:
    """Read TOSCA: files named by the class and the number of the pose, such as cat0."""
    if classes is not None:
        raise BenchmarkError("the files of TOSCA are named by their classes; leave --classes out")
    sources: list[tuple[str, tuple[Path, ...], Callable[[], Mesh]]] = []
    for path in sorted(folder.rglob("*.mat")):
        sources.append((path.stem, (path,), partial(read_mat_mesh, path)))
    for path in sorted(folder.rglob("*.vert")):
        triangles = path.with_suffix(".tri")
        sources.append((path.stem, (path, triangles), partial(read_vert_mesh, path, triangles)))
    if not sources:
        sources = [(path.stem, (path,), partial(read_mesh, path)) for path in _mesh_files(folder)]
    shapes = []
    for name, files, mesh in sources:
        parts = re.fullmatch(r"(.*?\D)\d+", name)
        if parts is None:
            raise BenchmarkError(
                f"'{files[0].name}' is not named by a class and a number, such as cat0{files[0].suffix}"
            )
        shapes.append(PublishedShape(name, parts[1], files, mesh))
    repeated = [name for name, count in Counter(shape.name for shape in shapes).items() if count > 1]
    if repeated:
        raise BenchmarkError(f"'{folder}' has {repeated[0]!r} more than once; keep one format only")
    return shapes


def _by_folder(folder: Path, classes: Path | None) -> list[PublishedShape]:
    """Read any collection that was sorted into one folder for each class."""
    if classes is not None:
        raise BenchmarkError("the classes are the names of the sub-folders; leave --classes out")
    shapes = []
    for path in _mesh_files(folder):
        place = path.relative_to(folder.resolve() if path.is_relative_to(folder.resolve()) else folder)
        if len(place.parts) < 2:
            raise BenchmarkError(f"'{place}' is in no sub-folder of '{folder}', so it has no class")
        shapes.append(
            PublishedShape(
                place.with_suffix("").as_posix(), place.parts[0], (path,), partial(read_mesh, path)
            )
        )
    return shapes


LAYOUTS: dict[str, Reader] = {
    "psb": _classified,
    "shrec11": _classified,
    "shrec07": _numbered,
    "tosca": _by_name,
    "folders": _by_folder,
}
"""Readers by the name of the collection."""


# -- files of TOSCA -----------------------------------------------------------------------------------------


def read_mat_mesh(path: Path) -> Mesh:
    """Read a mesh of TOSCA's MATLAB files: a structure ``surface`` with ``X``, ``Y``, ``Z`` and ``TRIV``.

    Parameters
    ----------
    path : Path

    Returns
    -------
    mesh : Mesh

    Raises
    ------
    MeshError
        If the file cannot be read or has no such structure.
    """
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        surface = loadmat(path, squeeze_me=True, struct_as_record=False)["surface"]
        vertices = np.stack([np.ravel(getattr(surface, axis)) for axis in ("X", "Y", "Z")], axis=1)
        faces = np.asarray(surface.TRIV, np.int64).reshape(-1, 3)
    except (KeyError, AttributeError, MatReadError, NotImplementedError, OSError, ValueError) as error:
        raise MeshError(
            f"'{path}' has no structure 'surface' with X, Y, Z and TRIV, as the files of TOSCA have"
        ) from error
    return _checked(path, vertices, faces)


def read_vert_mesh(vertices: Path, faces: Path) -> Mesh:
    """Read a mesh of TOSCA's text files.

    Parameters
    ----------
    vertices : Path
        ``.vert``: a vertex in each line.
    faces : Path
        ``.tri``: a triangle in each line, vertices counted from 1.

    Returns
    -------
    mesh : Mesh

    Raises
    ------
    MeshError
        If a file is missing or does not have three numbers in each line.
    """
    try:
        points = np.loadtxt(vertices, ndmin=2)
        triangles = np.loadtxt(faces, dtype=np.int64, ndmin=2)
    except OSError as error:
        raise MeshError(f"'{vertices}' needs its triangles in '{faces.name}' beside it") from error
    except ValueError as error:
        raise MeshError(f"'{vertices}' and '{faces.name}' must have three numbers in each line") from error
    return _checked(vertices, points, triangles)


def _checked(path: Path, vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Mesh:
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise MeshError(f"'{path}' must have three numbers for each vertex and triangle")
    if faces.size and not (faces.min() >= 1 and faces.max() <= len(vertices)):
        raise MeshError(
            f"'{path}' has triangles of vertices {faces.min()} to {faces.max()}, but its {len(vertices)} "
            "vertices count from 1"
        )
    return Mesh(vertices, faces - 1, path.stem)
