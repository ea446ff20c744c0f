# SPDX-License-Identifier: MIT
"""Model parts of a 3MF: objects with meshes or components, and the items to build, in millimetres."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, check_face_count
from shapegoogle_core.mesh.io.three_mf.package import Package, parse_xml
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Model", "ModelObject", "Reference", "read_model"]

_CORE = (
    "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/2013/01",
)
_PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
_SLICES = "http://schemas.microsoft.com/3dmanufacturing/slice/2015/07"
_LATTICES = (
    "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02",
    "http://schemas.microsoft.com/3dmanufacturing/beamlattice/balls/2020/07",
)
_IGNORED = (
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
)
_READ = frozenset({*_CORE, _PRODUCTION, _SLICES, *_IGNORED})

_LATTICE_NOTE = "has beam lattices beside its triangles, which are not read; they were left out"
_SLICE_NOTE = "stores its shape in slices, which are not read; its coarse mesh was read instead"

_MILLIMETRES = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}


@dataclass(frozen=True, eq=False)
class Reference:
    """An object in a place: a component of another object, or an item to build.

    Parameters
    ----------
    part : str
        Path of the model part that has the object.
    object_id : str
    matrix : (4, 4) array
        From the coordinates of the object to those of what refers to it.
    """

    part: str
    object_id: str
    matrix: FloatArray


@dataclass(frozen=True, eq=False)
class ModelObject:
    """An object of a model part.

    Parameters
    ----------
    name : str
        May be empty.
    kind : str
        Such as "model" or "support".
    vertices : (n, 3) array
    faces : (m, 3) array of int
    components : tuple of Reference
    notes : tuple of str
        What of the object is not read. Each completes the sentence "<file> …".
    """

    name: str
    kind: str
    vertices: FloatArray
    faces: NDArray[np.int64]
    components: tuple[Reference, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Model:
    """A model part.

    Parameters
    ----------
    objects : dict of str to ModelObject
        By id.
    items : list of Reference
        What is built; only those of the part that the package begins with count.
    """

    objects: dict[str, ModelObject]
    items: list[Reference]


def read_model(package: Package, part: str, max_faces: int) -> Model:
    """Read a model part.

    Parameters
    ----------
    package : Package
    part : str
        Its path.
    max_faces : int

    Returns
    -------
    model : Model

    Raises
    ------
    FormatError
        If it is damaged, requires an extension that cannot be read, or has too many faces.
    """
    parser = _ModelParser(package, part, max_faces)
    handlers = {f"{space}}}{name}": handler for space in _CORE for name, handler in parser.handlers.items()}
    ends = {f"{space}}}object" for space in _CORE}
    lattices = {f"{space}}}beamlattice" for space in _LATTICES}

    def start(name: str, attributes: dict[str, str]) -> None:
        handler = handlers.get(name)
        if handler is not None:
            handler(attributes)
        elif name in lattices:
            parser.note(_LATTICE_NOTE)

    def end(name: str) -> None:
        if name in ends:
            parser.finish_object()

    parse_xml(package, part, start, end, parser.declare)
    if not parser.is_model:
        raise FormatError(f"has a part {part!r} that is not a 3MF model; export it again")
    return Model(parser.objects, parser.items)


@dataclass(eq=False)
class _OpenObject:
    """An object whose element has begun."""

    identity: str
    name: str
    kind: str
    numbers: array[float] = field(default_factory=lambda: array("d"))
    corners: array[int] = field(default_factory=lambda: array("q"))
    components: list[Reference] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


class _ModelParser:
    """Takes the elements of a model part."""

    def __init__(self, package: Package, part: str, max_faces: int) -> None:
        self.objects: dict[str, ModelObject] = {}
        self.items: list[Reference] = []
        self.is_model = False
        self._open: _OpenObject | None = None
        self._package, self._part, self._max_faces = package, part, max_faces
        self._unit = 1.0
        self._namespaces: dict[str, str] = {}
        self._face_count = 0
        self.handlers = {
            "model": self._model,
            "object": self._object,
            "vertex": self._vertex,
            "triangle": self._triangle,
            "component": self._component,
            "item": self._item,
        }

    def declare(self, prefix: str, namespace: str) -> None:
        self._namespaces[prefix] = namespace

    def _model(self, attributes: dict[str, str]) -> None:
        self.is_model = True
        unit = attributes.get("unit", "millimeter").strip().lower()
        if unit not in _MILLIMETRES:
            raise FormatError(f"has the unknown unit {unit[:20]!r}; export it in millimetres")
        self._unit = _MILLIMETRES[unit]
        for prefix in attributes.get("requiredextensions", "").split():
            extension = self._namespaces.get(prefix, prefix)
            if extension not in _READ:
                raise FormatError(
                    f"requires the 3MF extension {extension[:100]}, which cannot be read; "
                    "export it without this extension, as plain meshes"
                )

    def _object(self, attributes: dict[str, str]) -> None:
        identity = attributes["id"]
        if identity in self.objects:
            raise DamagedError(f"has two objects with the id {identity[:20]!r} in its part {self._part!r}")
        self._open = _OpenObject(
            identity, attributes.get("name", "").strip(), attributes.get("type", "model")
        )
        if attributes.get(f"{_SLICES}}}meshresolution") == "lowres":
            self.note(_SLICE_NOTE)

    def _inside(self) -> _OpenObject:
        if self._open is None:
            raise ValueError("is outside of an object")
        return self._open

    def note(self, sentence: str) -> None:
        """Note what of the open object is not read."""
        self._inside().notes.append(sentence)

    def _vertex(self, attributes: dict[str, str]) -> None:
        x, y, z = float(attributes["x"]), float(attributes["y"]), float(attributes["z"])
        self._inside().numbers.extend((x, y, z))

    def _triangle(self, attributes: dict[str, str]) -> None:
        a, b, c = int(attributes["v1"]), int(attributes["v2"]), int(attributes["v3"])
        self._inside().corners.extend((a, b, c))

    def finish_object(self) -> None:
        """Check an object that ends, and note it."""
        found, self._open = self._inside(), None
        self._face_count += len(found.corners) // 3
        check_face_count(self._face_count, self._max_faces)
        vertices = np.array(found.numbers, np.float64).reshape(-1, 3) * self._unit
        faces = np.array(found.corners, np.int64).reshape(-1, 3)
        if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
            strange = faces[(faces < 0) | (faces >= len(vertices))][0]
            raise DamagedError(
                f"has a triangle that names vertex {strange}, counted from 0, of the {len(vertices):,} of "
                f"the object {found.identity[:20]!r} in its part {self._part!r}"
            )
        self.objects[found.identity] = ModelObject(
            found.name, found.kind, vertices, faces, tuple(found.components), tuple(found.notes)
        )

    def _component(self, attributes: dict[str, str]) -> None:
        self._inside().components.append(self._reference(attributes))

    def _item(self, attributes: dict[str, str]) -> None:
        self.items.append(self._reference(attributes))

    def _reference(self, attributes: dict[str, str]) -> Reference:
        path = attributes.get(f"{_PRODUCTION}}}path")
        part = self._part if path is None else self._package.resolve(path, self._part)
        matrix = np.eye(4)
        if "transform" in attributes:
            numbers = np.array([float(word) for word in attributes["transform"].split()])
            if not np.isfinite(numbers).all():
                raise ValueError("is not finite")
            # Points are rows in 3MF: the last of four rows is the translation.
            matrix[:3] = numbers.reshape(4, 3).T
            matrix[:3, 3] *= self._unit
        return Reference(part, attributes["objectid"], matrix)
