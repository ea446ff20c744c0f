# SPDX-License-Identifier: MIT
"""Measure the time of spectra from vertices and faces, compared with LaPy and pyfmaps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

from benchmarks.speed.measuring import Contestant, Options, Row, installed, race
from benchmarks.speed.meshes import creature
from benchmarks.speed.reporting import label, panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from shapegoogle_core import Mesh
    from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["EIGENPAIRS", "REPEATS", "SIZES", "draw", "measure"]

SIZES, REPEATS = (1_000, 10_000, 30_000, 100_000), 5

SHUFFLED_SIZE = 10_000
EIGENPAIRS = (10, 20, 100, 200)


def measure(options: Options) -> Iterator[Row]:
    """Time k eigenpairs of the cotangent Laplacian with lumped mass, which all contestants have.

    Parameters
    ----------
    options : Options
        Sizes are numbers of vertices.

    Yields
    ------
    row : dict
        See `race`. "error" is the largest |λ - λ'| / max(λ', λ'_2), with λ' of ARPACK
        (`scipy.sparse.linalg.eigsh`) at full precision.
    """
    from threadpoolctl import threadpool_limits

    for size in options.sizes:
        mesh = creature(size, tolerance=0.02)
        tasks = [(mesh, f"k = {k}", k) for k in EIGENPAIRS if 3 * k <= len(mesh.vertices)]
        if size == SHUFFLED_SIZE:
            tasks.append((shuffled_sphere(), "k = 100, shuffled sphere", 100))
        for surface, task, k in tasks:
            with threadpool_limits(1):
                reference = arpack_eigenvalues(surface, k)
                ways = contestants(surface, k, partial(deviation, expected=reference))
                yield from race(task, len(surface.vertices), ways, options.repeats)


def shuffled_sphere() -> Mesh:
    """Make a bumpy sphere of 10,242 vertices in random order, which is hard on orderings of the matrix."""
    import numpy as np
    import trimesh

    from shapegoogle_core import Mesh

    random = np.random.default_rng(0)
    ball = trimesh.creation.icosphere(5)
    x, y, z = ball.vertices.T
    bumps = 1 + 0.1 * np.sin(5 * x) * np.cos(4 * y) + 0.05 * np.sin(9 * z)
    place = random.permutation(len(ball.vertices))
    vertices = np.empty_like(ball.vertices)
    vertices[place] = ball.vertices * bumps[:, None]
    return Mesh(vertices, random.permutation(place[ball.faces]), name="shuffled sphere")


def contestants(mesh: Mesh, k: int, error: Callable[[FloatArray], float]) -> list[Contestant]:
    """List this package, then the other packages that are installed."""
    found = [Contestant("shapegoogle", partial(eigenvalues, mesh, k, "cotangent"), error)]
    if installed("lapy", "cholespy"):
        found.append(Contestant("LaPy with CHOLMOD", partial(lapy_eigenvalues, mesh, k, cholmod=True), error))
    if installed("lapy"):
        found.append(Contestant("LaPy", partial(lapy_eigenvalues, mesh, k, cholmod=False), error))
    if installed("pyFM", "potpourri3d"):
        found.append(Contestant("pyfmaps", partial(pyfmaps_eigenvalues, mesh, k), error))
    # The default discretisation of this package.
    found.append(Contestant("shapegoogle, robust", partial(eigenvalues, mesh, k, "robust")))
    return found


def eigenvalues(mesh: Mesh, k: int, laplacian: str) -> FloatArray:
    from shapegoogle_core import Mesh, compute_spectrum

    return compute_spectrum(Mesh(mesh.vertices, mesh.faces), k, laplacian).eigenvalues


def lapy_eigenvalues(mesh: Mesh, k: int, cholmod: bool) -> FloatArray:
    import numpy as np
    from lapy import Solver, TriaMesh

    solver = Solver(TriaMesh(np.array(mesh.vertices), np.array(mesh.faces)), lump=True, use_cholmod=cholmod)
    return np.asarray(solver.eigs(k)[0], dtype=np.float64)


def pyfmaps_eigenvalues(mesh: Mesh, k: int) -> FloatArray:
    import numpy as np
    from pyFM.mesh import TriMesh

    surface = TriMesh(np.array(mesh.vertices), np.array(mesh.faces))
    surface.process(k=k, intrinsic=False)
    return np.asarray(surface.eigenvalues, dtype=np.float64)


def arpack_eigenvalues(mesh: Mesh, k: int) -> FloatArray:
    """Solve with `eigsh`, shifted just below the spectrum."""
    import numpy as np
    from scipy.sparse.linalg import eigsh

    from shapegoogle_core.laplacian import build_operator

    operator = build_operator(mesh, "cotangent")
    shift = -0.05 * 4 * np.pi / operator.mass.sum()
    start = np.random.default_rng(0).standard_normal(len(mesh.vertices))
    values = eigsh(operator.stiffness, k, M=operator.mass, sigma=shift, v0=start, return_eigenvectors=False)
    return np.sort(values)


def deviation(values: FloatArray, expected: FloatArray) -> float:
    """Compute the largest |λ - λ'| / max(λ', λ'_2)."""
    import numpy as np

    return float((np.abs(np.sort(values) - expected) / np.maximum(expected, expected[1])).max())


def draw(rows: Sequence[Row]) -> Figure:
    """Plot processor time against size, a panel for each k, a line for each contestant.

    Parameters
    ----------
    rows : sequence of dict
        From `measure`.

    Returns
    -------
    figure : matplotlib.figure.Figure
    """
    tasks = list(dict.fromkeys(row["task"] for row in rows))
    figure, axes = panels(len(tasks), 5.5 * len(tasks), 4.2)
    for panel, task in zip(axes, tasks, strict=True):
        members = [row for row in rows if row["task"] == task]
        for name in dict.fromkeys(row["contestant"] for row in members):
            line = sorted((row["size"], row["cpu_seconds"]) for row in members if row["contestant"] == name)
            panel.loglog(*zip(*line, strict=True), marker="o", label=name)
        panel.set(title=task, xlabel="vertices", ylabel="processor time, s")
        label(panel)
    return figure
