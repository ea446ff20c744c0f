# SPDX-License-Identifier: MIT
"""Reading with the readers that are Python packages, each file in a process that may crash or hang."""

from __future__ import annotations

import contextlib
import io
import logging
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from benchmarks.experiments.files.facts import FloatArray, IntArray, measure, triangles_of_polygons
from benchmarks.experiments.files.reading import PRODUCT, Limits, Parts, Reading
from shapegoogle_core import read_mesh
from shapegoogle_core.errors import MeshError
from shapegoogle_core.processes.pool import CrashError, Pool, TimeLimitError
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["read_in_pool"]


def read_in_pool(reader: str, paths: Sequence[Path], limits: Limits) -> list[Reading]:
    """Read files with the product, trimesh or meshio.

    Parameters
    ----------
    reader : str
    paths : sequence of Path
    limits : Limits

    Returns
    -------
    readings : list of Reading
        In the order of the paths.
    """
    function = {PRODUCT: _read_product, "trimesh": _read_trimesh, "meshio": _read_meshio}.get(reader)
    readings = []
    with Pool(limits.jobs, limits.seconds, memory_limit=limits.megabytes) as pool:
        tasks = pool.map(_timed, [(function, reader, path) for path in paths])
        for path, task in zip(paths, progress_bar(tasks, reader, len(paths)), strict=True):
            try:
                readings.append(task.result())
            except TimeLimitError:
                readings.append(Reading(reader, path, "time", [], f"took more than {limits.seconds:g} s"))
            except CrashError as error:
                readings.append(Reading(reader, path, "crash", [], f"its process ended by {error}"))
    return readings


def _timed(job: tuple[Callable[[Path], Parts], str, Path]) -> Reading:
    """Read a file in a process of the pool."""
    function, reader, path = job
    logging.disable()  # trimesh prints tracebacks of missing textures
    started = time.process_time()
    status, message, parts = "read", "", []
    try:
        parts = function(path)
    except MeshError as error:
        status, message = "refused", str(error)
    except (Exception, SystemExit) as error:  # whatever a reader raises is a result of the comparison
        status = "failed" if reader == PRODUCT else "refused"
        message = f"{type(error).__name__} {' '.join(str(error).split())}"
    if status == "read" and not parts:
        status = "nothing"
    return Reading(reader, path, status, parts, message, time.process_time() - started)


def _parts(vertices: FloatArray, faces: IntArray, area: float | None = None) -> Parts:
    facts = measure(vertices, faces, area)
    return [] if facts is None else [("", facts)]


def _read_product(path: Path) -> Parts:
    mesh = read_mesh(path)
    return _parts(mesh.vertices, mesh.faces.astype(np.int64))


def _read_trimesh(path: Path) -> Parts:
    import trimesh

    scene = trimesh.load_scene(path, process=False)
    vertices, faces, points, count = [], [], [], 0
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        item = scene.geometry[name]
        if not isinstance(item, trimesh.Trimesh | trimesh.PointCloud):
            continue
        places = trimesh.transform_points(item.vertices, matrix)
        if isinstance(item, trimesh.PointCloud):
            points.append(places)
            continue
        vertices.append(places)
        faces.append(np.asarray(item.faces) + count)
        count += len(places)
    if count:
        return _parts(np.concatenate(vertices), np.concatenate(faces))
    return _parts(np.concatenate(points), np.empty((0, 3), np.int64)) if points else []


def _read_meshio(path: Path) -> Parts:
    import meshio

    with contextlib.redirect_stdout(io.StringIO()):
        mesh = meshio.read(path)
    places = np.zeros((len(mesh.points), 3))
    places[:, : mesh.points.shape[1]] = mesh.points
    cells = [np.asarray(block.data) for block in mesh.cells if block.type in ("triangle", "quad", "polygon")]
    if not cells:
        return _parts(places, np.empty((0, 3), np.int64))
    cut = [triangles_of_polygons(places, polygons.astype(np.int64)) for polygons in cells]
    return _parts(places, np.concatenate([faces for faces, _ in cut]), sum(area for _, area in cut))
