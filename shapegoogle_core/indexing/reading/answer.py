# SPDX-License-Identifier: MIT
"""From the answer of another program that has read a file to the shapes of the file.

What the records and the arrays look like is described in `shapegoogle_core.indexing.reading.external_reader`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing.reading.naming import file_based_name, useful_name
from shapegoogle_core.indexing.reading.notes import FileNotes, LeftOut
from shapegoogle_core.library.origin import Origin
from shapegoogle_core.library.placement import placements_of
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["MeshPlace", "read_shape", "shapes_in"]

# Matrix of a mesh that has the coordinates of its shape.
_UNMOVED = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)


@dataclass(frozen=True)
class MeshPlace:
    """Where a mesh lies in the output file.

    Attributes
    ----------
    start : int
        In bytes.
    vertices, faces : int
        Their numbers.
    """

    start: int
    vertices: int
    faces: int


def shapes_in(
    path: Path, answer: Mapping[str, Any], output: Path
) -> Iterator[NewShape[Mesh] | FileNotes | str]:
    """Read the arrays that a program wrote, one shape at a time.

    Parameters
    ----------
    path : Path
        The file that the program has read.
    answer : mapping
        Its answer.
    output : Path
        File with the arrays.

    Yields
    ------
    found : NewShape, FileNotes or str
        A sentence for a part that cannot be read.
    """
    yield from map(str, answer["problems"])
    left_out = tuple(LeftOut(str(kind), int(count)) for kind, count in answer.get("left_out", {}).items())
    linked = tuple(map(str, answer.get("linked", ())))
    if left_out or linked:
        yield FileNotes(left_out, linked)
    up_axis, listed = answer["up_axis"], answer["shapes"]
    counts = answer.get("meshes", listed)
    sizes = [12 * (mesh["vertices"] + mesh["faces"]) for mesh in counts]
    places = [
        MeshPlace(start, mesh["vertices"], mesh["faces"])
        for start, mesh in zip(accumulate([0, *sizes]), counts, strict=False)
    ]
    joined: list[Mesh] = []
    with output.open("rb") as file:
        arrays = _Arrays(file, places)
        for number, record in enumerate(listed):
            own = {"parts": [{"mesh": number, "matrix": _UNMOVED}], **record}
            try:
                if answer["joined"]:
                    joined += [
                        mesh
                        for placement in own["placements"]
                        for mesh in arrays.placed(
                            own["parts"], _matrix(placement["matrix"]), str(placement["object"])
                        )
                    ]
                    continue
                yield _shape_of(own, path, arrays, up_axis, alone=len(listed) == 1)
            except MeshError as error:
                yield str(error)
    if joined:
        yield NewShape(_joined(joined, path.name), path.name, up_axis=up_axis)


def read_shape(
    path: Path,
    record: Mapping[str, Any],
    meshes: Sequence[MeshPlace],
    output: Path,
    *,
    up_axis: int,
    alone: bool,
) -> NewShape[Mesh]:
    """Read the arrays of one shape.

    Parameters
    ----------
    path : Path
        The file that it is in.
    record : mapping
        One of the "shapes" of an answer.
    meshes : sequence of MeshPlace
        Those that the numbers of its parts mean.
    output : Path
        File with the arrays.
    up_axis : int
    alone : bool
        Whether it is the only shape of its file, after which it may be named.

    Returns
    -------
    shape : NewShape

    Raises
    ------
    MeshError
        If it is no usable mesh.
    """
    with output.open("rb") as file:
        return _shape_of(record, path, _Arrays(file, meshes), up_axis, alone=alone)


def _shape_of(
    record: Mapping[str, Any], path: Path, arrays: _Arrays, up_axis: int, *, alone: bool
) -> NewShape[Mesh]:
    name = str(record["name"])
    objects = [(str(placement["object"]), _matrix(placement["matrix"])) for placement in record["placements"]]
    placed = arrays.placed(record["parts"], objects[0][1], name)
    mesh = placed[0] if len(placed) == 1 else _joined(placed, name)
    shape = NewShape(mesh, name, name, placements=placements_of(mesh, objects), up_axis=up_axis)
    return _described(shape, record, path, alone=alone)


def _described(
    shape: NewShape[Mesh], record: Mapping[str, Any], path: Path, *, alone: bool
) -> NewShape[Mesh]:
    """Add to a shape what its record says of it besides its mesh."""
    frame = record.get("frame")
    title = useful_name(shape.name, map(str, record.get("names", ())))
    named_after_file = not title
    title = title or file_based_name(path, shape.name, alone=alone)
    origin = Origin(record.get("type"), str(record.get("catalog", "")), frame)
    return replace(
        shape,
        name=title if frame is None else f"{title} @ {frame}",
        tags=tuple(map(str, record.get("tags", ()))),
        origin=origin,
        named_after_file=named_after_file,
        color=_color(record.get("color")),
    )


def _color(listed: Sequence[float] | None) -> tuple[float, float, float] | None:
    if listed is None:
        return None
    red, green, blue = (min(max(float(value), 0.0), 1.0) for value in listed)
    return red, green, blue


class _Arrays:
    """The meshes in the output file; the one that was read last is kept.

    Parameters
    ----------
    file : file object
    places : sequence of MeshPlace
    """

    def __init__(self, file: BinaryIO, places: Sequence[MeshPlace]) -> None:
        self._file = file
        self._places = places
        self._last: tuple[int, tuple[NDArray[np.float32], NDArray[np.int32]]] | None = None

    def read(self, number: int) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Return vertices (n, 3) and faces (m, 3) of a mesh."""
        if self._last is None or self._last[0] != number:
            place = self._places[number]
            self._file.seek(place.start)
            vertices = np.fromfile(self._file, "<f4", 3 * place.vertices).reshape(-1, 3)
            faces = np.fromfile(self._file, "<i4", 3 * place.faces).reshape(-1, 3)
            self._last = number, (vertices, faces)
        return self._last[1]

    def placed(self, parts: Sequence[Mapping[str, Any]], matrix: FloatArray, name: str) -> list[Mesh]:
        """Return the meshes of a shape, each where a placement has it."""
        return [_placed(*self.read(part["mesh"]), matrix @ _matrix(part["matrix"]), name) for part in parts]


def _matrix(numbers: Sequence[float]) -> FloatArray:
    return np.array(numbers, np.float64).reshape(4, 4)


def _placed(vertices: NDArray[np.float32], faces: NDArray[np.int32], matrix: FloatArray, name: str) -> Mesh:
    """Transform a mesh to the coordinates of its file."""
    if np.linalg.det(matrix[:3, :3]) < 0:
        faces = faces[:, ::-1]  # a mirrored object would come out inside out
    return Mesh(vertices @ matrix[:3, :3].T + matrix[:3, 3], faces, name)


def _joined(meshes: Sequence[Mesh], name: str) -> Mesh:
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=False)]),
        name,
    )
