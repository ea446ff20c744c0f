# SPDX-License-Identifier: MIT
"""The plate of a 3MF: which objects are built, from which components, and where."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.three_mf.model import Model, ModelObject, Reference, read_model
from shapegoogle_core.mesh.io.three_mf.package import Package
from shapegoogle_core.mesh.io.three_mf.slicer import apply_slicer_settings
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["PlateObject", "read_plate", "read_three_mf"]

# Supports are printed but no part of what is made, and other objects only serve as components of these.
_SHAPES = ("model", "surface")
_MOST_LEVELS = 100
_MOST_COMPONENTS = 1_000_000

_Key = tuple[str, str]


@dataclass(frozen=True, eq=False)
class PlateObject:
    """An object of a plate.

    Parameters
    ----------
    name : str
        May be empty.
    polygons : Polygons
        With its components, in its own coordinates in millimetres.
    matrices : sequence of (4, 4) array
        Its places on the plate, one for each time that it is built.
    """

    name: str
    polygons: Polygons
    matrices: Sequence[FloatArray]

    def placed(self, matrix: FloatArray) -> Polygons:
        """Return the polygons in a place."""
        return _placed(self.polygons, matrix)


def read_three_mf(file: MeshFile) -> Polygons:
    """Read the whole plate of a 3MF file as one mesh, in millimetres; see `read_plate`."""
    placed = [found.placed(matrix) for found in read_plate(file) for matrix in found.matrices]
    return _joined(placed)


def read_plate(file: MeshFile) -> list[PlateObject]:
    """Read the objects that a 3MF file builds; all that no other has as a component if it builds none.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    objects : list of PlateObject
        In the order in which they are built first. Supports are left out.

    Raises
    ------
    FormatError
        If the file is damaged, requires an extension that cannot be read, has no triangles or too many.
    """
    plate = _Plate(file)
    items = plate.items()
    sizes: dict[_Key, tuple[int, int]] = {}
    faces = sum(plate.size((item.part, item.object_id), sizes)[0] for item in items)
    check_face_count(faces, file.max_faces)
    places: dict[_Key, list[FloatArray]] = {}
    for item in items:
        if sizes[item.part, item.object_id][0]:
            places.setdefault((item.part, item.object_id), []).append(item.matrix)
    if not places:
        raise FormatError(
            "builds no object with triangles: it has only supports, slices or lattices, or none at all; "
            "export it with its meshes"
        )
    return [
        PlateObject(plate.object(key).name, _joined(list(plate.parts(key, np.eye(4)))), matrices)
        for key, matrices in places.items()
    ]


class _Plate:
    """The objects of all model parts of a file."""

    def __init__(self, file: MeshFile) -> None:
        self._package = Package(file)
        self._max_faces = file.max_faces
        self._models: dict[str, Model] = {}
        self._start = self._package.start_part()

    def items(self) -> list[Reference]:
        """List what is built."""
        model = self._model(self._start)
        if model.items:
            return model.items
        components = {
            (component.part, component.object_id)
            for found in model.objects.values()
            for component in found.components
        }
        return [
            Reference(self._start, identity, np.eye(4))
            for identity in model.objects
            if (self._start, identity) not in components
        ]

    def object(self, key: _Key) -> ModelObject:
        """Return an object; `DamagedError` if it is not there."""
        part, identity = key
        found = self._model(part).objects.get(identity)
        if found is None:
            raise DamagedError(f"names the object {identity[:20]!r} of its part {part!r}, which is not there")
        return found

    def size(self, key: _Key, sizes: dict[_Key, tuple[int, int]], level: int = 0) -> tuple[int, int]:
        """Count the triangles and components of an object, before they are put together."""
        if key in sizes:
            return sizes[key]
        if level > _MOST_LEVELS:
            raise FormatError(
                f"has components within components on more than {_MOST_LEVELS} levels, or an object within "
                "itself; export it again"
            )
        found = self.object(key)
        faces, components = len(found.faces), 1
        for component in found.components:
            more, parts = self.size((component.part, component.object_id), sizes, level + 1)
            faces, components = faces + more, components + parts
        if found.kind not in _SHAPES:
            faces, components = 0, 1
        check_face_count(faces, self._max_faces)
        if components > _MOST_COMPONENTS:
            raise FormatError(f"has more than {_MOST_COMPONENTS:,} components; export it again")
        sizes[key] = faces, components
        return sizes[key]

    def parts(self, key: _Key, matrix: FloatArray) -> Iterator[Polygons]:
        """Return the meshes of an object and of its components, in their places."""
        found = self.object(key)
        if found.kind not in _SHAPES:
            return
        if len(found.faces):
            mesh = Polygons.from_triangles(found.vertices, found.faces)
            yield _placed(replace(mesh, notes=found.notes), matrix)
        for component in found.components:
            yield from self.parts((component.part, component.object_id), matrix @ component.matrix)

    def _model(self, part: str) -> Model:
        if part not in self._models:
            model = read_model(self._package, part, self._max_faces)
            if part == self._start:
                model = apply_slicer_settings(self._package, model)
            self._models[part] = model
        return self._models[part]


def _placed(polygons: Polygons, matrix: FloatArray) -> Polygons:
    if np.array_equal(matrix, np.eye(4)):
        return polygons
    with np.errstate(invalid="ignore", over="ignore"):  # such points are dropped or refused later
        vertices = polygons.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    faces = polygons.corners.reshape(-1, 3)
    mirrored = np.linalg.det(matrix[:3, :3]) < 0  # its faces would come out inside out
    return replace(
        Polygons.from_triangles(vertices, faces[:, ::-1] if mirrored else faces), notes=polygons.notes
    )


def _joined(parts: Sequence[Polygons]) -> Polygons:
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    corners = [part.corners + start for part, start in zip(parts, starts, strict=False)]
    joined = Polygons.from_triangles(
        np.concatenate([part.vertices for part in parts]), np.concatenate(corners).reshape(-1, 3)
    )
    notes = dict.fromkeys(note for part in parts for note in part.notes)  # each once
    return replace(joined, notes=tuple(notes))
