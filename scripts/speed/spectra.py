# SPDX-License-Identifier: MIT
"""Spectra from vertices and faces, against LaPy and pyfmaps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from speed.measuring import Contestant, Options, Row, installed, race

if TYPE_CHECKING:
    from shapegoogle_core import Mesh
    from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["EIGENPAIRS", "measure", "shape"]

EIGENPAIRS = (100, 200)
# A creature that nothing was learnt from. Larger meshes come from one of this many vertices.
KIND, SEED, LARGEST_CREATURE = "horse", 100, 20_000


def shape(vertices: int) -> Mesh:
    """Make a closed surface of about so many vertices, irregular ones."""
    import numpy as np
    import trimesh

    from shapegoogle_core import Mesh
    from shapegoogle_core.evaluation.creatures import make_creature
    from shapegoogle_core.mesh.resampling import simplify

    mesh = make_creature(KIND, SEED, min(vertices, LARGEST_CREATURE)).rest
    while len(mesh.vertices) < 0.98 * vertices:
        # Curved, so that simplifying does not leave slivers on flat patches.
        finer = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).subdivide_loop(1)
        mesh = Mesh(np.asarray(finer.vertices), np.asarray(finer.faces, dtype=np.int32), name=mesh.name)
    return mesh if len(mesh.vertices) < 1.02 * vertices else simplify(mesh, vertices)


def measure(options: Options) -> Iterator[Row]:
    """Time k eigenpairs of the cotangent Laplacian with lumped mass, which all of the contestants have.

    The error is the largest |λ - λ'| / max(λ', λ'_2) against ARPACK (`scipy.sparse.linalg.eigsh`) at its
    full precision.
    """
    for size in options.sizes:
        mesh = shape(size)
        for k in EIGENPAIRS:
            if 3 * k > len(mesh.vertices):
                continue
            reference = arpack_eigenvalues(mesh, k)
            yield from race(
                "spectra",
                f"k = {k}",
                len(mesh.vertices),
                contestants(mesh, k, partial(deviation, expected=reference)),
                options.repeats,
            )


def contestants(mesh: Mesh, k: int, error: Callable[[FloatArray], float]) -> list[Contestant]:
    """List this package, then those of the others that are installed."""
    found = [Contestant("shapegoogle", partial(eigenvalues, mesh, k, "cotangent"), error)]
    if installed("lapy", "cholespy"):
        found.append(Contestant("LaPy with CHOLMOD", partial(lapy_eigenvalues, mesh, k, cholmod=True), error))
    if installed("lapy"):
        found.append(Contestant("LaPy", partial(lapy_eigenvalues, mesh, k, cholmod=False), error))
    if installed("pyFM", "potpourri3d"):
        found.append(Contestant("pyfmaps", partial(pyfmaps_eigenvalues, mesh, k), error))
    # The default of this package, another discretisation.
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
    """Solve with `eigsh`, its shift just below the spectrum."""
    import numpy as np
    from scipy.sparse.linalg import eigsh

    from shapegoogle_core.laplacian import build_operator

    operator = build_operator(mesh, "cotangent")
    shift = -0.05 * 4 * np.pi / operator.mass.sum()
    start = np.random.default_rng(0).standard_normal(len(mesh.vertices))
    values = eigsh(operator.stiffness, k, M=operator.mass, sigma=shift, v0=start, return_eigenvectors=False)
    return np.sort(values)


def deviation(values: FloatArray, expected: FloatArray) -> float:
    """Largest |λ - λ'| / max(λ', λ'_2)."""
    import numpy as np

    return float((np.abs(np.sort(values) - expected) / np.maximum(expected, expected[1])).max())
