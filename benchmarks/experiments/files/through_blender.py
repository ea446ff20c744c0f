# SPDX-License-Identifier: MIT
"""Reading through Blender: as the product does it, and with Blender alone."""

from __future__ import annotations

import importlib.util
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np

from benchmarks.errors import BenchmarkError
from benchmarks.experiments.files import gltf_at_rest
from benchmarks.experiments.files.facts import FloatArray, IntArray, measure
from benchmarks.experiments.files.reading import BLENDER, BLENDER_SUFFIXES, PRODUCT, Limits, Parts, Reading
from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing.reading.external_reader import ExternalReader, ReaderProcess
from shapegoogle_core.indexing.reading.notes import FileNotes
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.processes.launching import cause_of_death
from shapegoogle_core.processes.program import Program
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["find_blender", "read_through_blender"]

# Seconds that Blender may take to start.
START_LIMIT = 120.0
READER_OF_THE_PRODUCT = Path(__file__).resolve().parents[3] / "blender_addon" / "reading" / "reader.py"


def find_blender(program: str | None) -> tuple[str, ...] | None:
    """Return the command that runs a script in Blender.

    Parameters
    ----------
    program : str or None
        A Blender, or a Python that has the module bpy; None for this Python, if it has it.

    Returns
    -------
    command : tuple of str or None
        To be followed by the script; None without a Blender.
    """
    if program is None:
        return (sys.executable,) if importlib.util.find_spec("bpy") else None
    if Path(program).name.startswith("python"):
        return (program,)
    return (program, "--background", "--factory-startup", "--disable-autoexec", "--python")


def read_through_blender(
    reader: str, paths: Sequence[Path], limits: Limits, blender: tuple[str, ...]
) -> list[Reading]:
    """Read files with several Blenders, which take turns.

    Parameters
    ----------
    reader : str
        "product" for its own script in Blender, "Blender" for Blender's importers.
    paths : sequence of Path
    limits : Limits
    blender : tuple of str
        See `find_blender`.

    Returns
    -------
    readings : list of Reading
        In the order of the paths.
    """
    kind = _AsTheProduct if reader == PRODUCT else _Alone
    blenders = [kind(limits, blender) for _ in range(limits.jobs)]
    free = SimpleQueue[_AsTheProduct | _Alone]()
    for each in blenders:
        free.put(each)

    def read(path: Path) -> Reading:
        one = free.get()
        try:
            return one.read(path)
        finally:
            free.put(one)

    with ThreadPoolExecutor(limits.jobs) as threads:
        try:
            return list(progress_bar(threads.map(read, paths), f"{reader} in Blender", len(paths)))
        finally:
            for each in blenders:
                each.close()


class _AsTheProduct:
    """A Blender that reads as the add-on does."""

    def __init__(self, limits: Limits, blender: tuple[str, ...]) -> None:
        self._process = ReaderProcess(
            ExternalReader(
                BLENDER_SUFFIXES,
                (*blender, str(READER_OF_THE_PRODUCT)),
                BLENDER,
                time_limit=limits.seconds,
                memory_limit=limits.megabytes,
            )
        )

    def read(self, path: Path) -> Reading:
        started = time.monotonic()
        parts: Parts = []
        problems = []
        try:
            for shape in self._process.read(path):
                if isinstance(shape, str):
                    problems.append(shape)
                elif not isinstance(shape, FileNotes):
                    parts += _placed(shape)
            status = "read" if parts else "nothing"
        except MeshError as error:
            status, parts, problems = "refused", [], [str(error)]
        return Reading(PRODUCT, path, status, parts, " ".join(problems), time.monotonic() - started)

    def close(self) -> None:
        self._process.close()


class _Alone:
    """A Blender that imports or opens files and tells what it evaluates."""

    def __init__(self, limits: Limits, blender: tuple[str, ...]) -> None:
        self._limit = limits.seconds
        self._command = (*blender, str(Path(__file__).with_name("in_blender.py")))
        self._program: Program | None = None

    def read(self, path: Path) -> Reading:
        if self._program is None:
            self._program = _started(self._command)
        started = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            output = Path(folder, "parts.bin")
            is_gltf = path.suffix.lower() in gltf_at_rest.SUFFIXES
            given = gltf_at_rest.without_animations(path, Path(folder)) if is_gltf else path
            self._program.send({"path": str(given.absolute()), "output": str(output)})
            try:
                answer = self._program.message(self._limit)
            except TimeoutError:
                self.close()
                return Reading(BLENDER, path, "time", [], f"took more than {self._limit:g} s")
            if answer is None:
                code = self._program.close()
                self._program = None
                return Reading(BLENDER, path, "crash", [], f"its process ended by {cause_of_death(code)}")
            seconds = time.monotonic() - started
            if "error" in answer:
                return Reading(BLENDER, path, "refused", [], str(answer["error"]), seconds)
            parts = _parts_of(answer["parts"], output, turned=is_gltf)
        return Reading(BLENDER, path, "read" if parts else "nothing", parts, "", seconds)

    def close(self) -> None:
        program, self._program = self._program, None
        if program is not None:
            program.close()


def _placed(shape: NewShape[Mesh]) -> Parts:
    """Measure the mesh of a shape at each of its placements."""
    faces = shape.mesh.faces.astype(np.int64)
    if not shape.placements:
        facts = measure(shape.mesh.vertices, faces)
        return [] if facts is None else [("", facts)]
    parts = []
    home = np.linalg.inv(shape.placements[0].matrix)
    for placement in shape.placements:
        moved = placement.matrix @ home
        facts = measure(shape.mesh.vertices @ moved[:3, :3].T + moved[:3, 3], faces)
        if facts is not None:
            parts.append((placement.object_name, facts))
    return parts


def _started(command: Sequence[str]) -> Program:
    try:
        program = Program(command, with_input=True)
        ready = program.message(START_LIMIT)
    except (OSError, TimeoutError) as error:
        raise BenchmarkError(
            f"Blender cannot be started at {command[0]!r}; name another one with --blender"
        ) from error
    if ready is None:
        program.close()
        raise BenchmarkError(f"Blender at {command[0]!r} ends at once; name another one with --blender")
    return program


def _parts_of(records: Sequence[dict[str, Any]], output: Path, turned: bool) -> Parts:
    """Measure the arrays that Blender wrote; all of the same name are one part."""
    pieces: dict[str, list[tuple[FloatArray, IntArray]]] = {}
    with output.open("rb") as file:
        for record in records:
            vertices = np.fromfile(file, "<f4", 3 * record["vertices"]).reshape(-1, 3).astype(np.float64)
            faces = np.fromfile(file, "<i4", 3 * record["faces"]).reshape(-1, 3).astype(np.int64)
            matrix = np.array(record["matrix"]).reshape(4, 4)
            places = vertices @ matrix[:3, :3].T + matrix[:3, 3]
            if turned:  # Blender turned the y axis of glTF to its z axis
                places = places[:, [0, 2, 1]] * [1, 1, -1]
            pieces.setdefault(record["name"], []).append((places, faces))
    parts = []
    for name, meshes in pieces.items():
        solid = [mesh for mesh in meshes if len(mesh[1])] or meshes
        offsets = np.cumsum([0, *(len(vertices) for vertices, _ in solid)])
        shifted = [triangles + offset for (_, triangles), offset in zip(solid, offsets, strict=False)]
        facts = measure(np.concatenate([vertices for vertices, _ in solid]), np.concatenate(shifted))
        if facts is not None:
            parts.append((name, facts))
    return parts
