# SPDX-License-Identifier: MIT
"""Figure of the error of eigenvalues against degrees of freedom, for each discretisation.

On a flat rectangle with Neumann and with Dirichlet boundary and on a sphere, whose eigenvalues are known.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import trimesh

from shapegoogle_core import Mesh, build_operator
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import operator_spectrum

__all__ = ["draw"]

# Markers and colours; the markers differ too, for readers who cannot distinguish the colours.
STYLES = {
    "cotangent": ("o", "#1b6ca8"),
    "cotangent-voronoi": ("x", "#4aa3df"),
    "robust": ("+", "#555555"),
    "fem1": ("s", "#d1495b"),
    "fem2": ("^", "#edae49"),
    "fem3": ("D", "#00798c"),
    "point-cloud": ("*", "#9b5de5"),
}
WIDTH, HEIGHT, PAIRS = 1.7, 1.0, 12
CELLS = (8, 16, 32, 64)
SUBDIVISIONS = (1, 2, 3, 4)
# Cubic elements on the finest mesh would take minutes, and reach the solver's accuracy on coarser ones.
MOST_FREEDOMS = 30_000


def rectangle(columns: int) -> Mesh:
    """Mesh the rectangle with right triangles on a grid."""
    rows = round(columns * HEIGHT / WIDTH)
    x, y = np.meshgrid(np.linspace(0, WIDTH, columns + 1), np.linspace(0, HEIGHT, rows + 1), indexing="ij")
    i, j = (index.ravel() for index in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    a = i * (rows + 1) + j
    b, c, d = a + rows + 1, a + rows + 2, a + 1
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1), faces, "rectangle")


def sphere(subdivisions: int) -> Mesh:
    """Mesh the unit sphere with flat triangles."""
    ball = trimesh.creation.icosphere(subdivisions)
    return Mesh(ball.vertices, ball.faces, "sphere")


def rectangle_eigenvalues(first: int) -> FloatArray:
    """Return π² ((m / width)² + (n / height)²) for m, n ≥ first: 0 for Neumann, 1 for Dirichlet."""
    m, n = np.meshgrid(np.arange(first, 12), np.arange(first, 12))
    values = np.pi**2 * ((m / WIDTH) ** 2 + (n / HEIGHT) ** 2)
    return np.sort(values.ravel())[:PAIRS]


def sphere_eigenvalues() -> FloatArray:
    """Return l (l + 1), each 2l + 1 times."""
    degrees = np.arange(5)
    return np.repeat(degrees * (degrees + 1.0), 2 * degrees + 1)


def errors(
    laplacian: str, boundary: str, meshes: list[Mesh], expected: FloatArray
) -> tuple[list[int], list[float]]:
    """Compute degrees of freedom and the largest relative errors of the positive eigenvalues."""
    freedoms, found = [], []
    for mesh in meshes:
        operator = build_operator(mesh, laplacian)
        count = operator.stiffness.shape[0]
        if count > MOST_FREEDOMS:
            break
        values = operator_spectrum(operator, len(expected), boundary).eigenvalues
        positive = expected > 0
        freedoms.append(count)
        found.append(float(np.abs(values[positive] / expected[positive] - 1).max()))
    return freedoms, found


def draw(path: Path) -> None:
    """Draw the figure, and print the orders of convergence in the length h of edges.

    The orders follow from the two finest meshes.

    Parameters
    ----------
    path : Path
        The .png file.
    """
    rectangles = [rectangle(cells) for cells in CELLS]
    spheres = [sphere(subdivisions) for subdivisions in SUBDIVISIONS]
    panels: list[tuple[str, str, list[Mesh], Callable[[], FloatArray]]] = [
        ("flat rectangle, free", "neumann", rectangles, lambda: rectangle_eigenvalues(0)),
        ("flat rectangle, held at 0", "dirichlet", rectangles, lambda: rectangle_eigenvalues(1)),
        ("sphere of flat triangles", "neumann", spheres, sphere_eigenvalues),
    ]
    figure, axes = plt.subplots(1, len(panels), figsize=(11, 4), sharey=True, layout="constrained")
    for axis, (title, boundary, meshes, expected) in zip(axes, panels, strict=True):
        for laplacian, (marker, color) in STYLES.items():
            if laplacian == "point-cloud" and boundary == "dirichlet":
                continue
            freedoms, found = errors(laplacian, boundary, meshes, expected())
            # Degrees of freedom grow as h⁻², so that an order p is a slope of −p/2.
            order = 2 * np.log(found[-2] / found[-1]) / np.log(freedoms[-1] / freedoms[-2])
            print(f"{title:28} {laplacian:18} h^{order:.1f}   {found[-1]:.1e} at {freedoms[-1]:,}")
            axis.loglog(freedoms, found, marker=marker, color=color, label=laplacian, linewidth=1.2)
        axis.set_title(title)
        axis.set_xlabel("degrees of freedom")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("largest relative error of the lowest eigenvalues")
    axes[0].legend(fontsize="small", loc="lower left")
    figure.savefig(path, dpi=110)
