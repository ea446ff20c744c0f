# SPDX-License-Identifier: MIT
"""Draw docs/images/operator_convergence.png: the error of eigenvalues against degrees of freedom.

    .venv/bin/python -m benchmarks.figures.operators [--output FILE.png]

On a flat rectangle, free and held at its rim, and on a sphere, whose eigenvalues are known. Prints the orders
in the length h of edges, from the two finest meshes of each. Needs matplotlib.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import trimesh

from shapegoogle_core import Mesh, build_operator
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import operator_spectrum

OUTPUT = Path(__file__).resolve().parents[2] / "docs" / "images" / "operator_convergence.png"
# Marks and colours, told apart without colours too.
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
# Cubic elements on the finest mesh take minutes and have reached the accuracy of the solver before.
MOST_FREEDOMS = 30_000


def rectangle(columns: int) -> Mesh:
    """Right triangles on a grid."""
    rows = round(columns * HEIGHT / WIDTH)
    x, y = np.meshgrid(np.linspace(0, WIDTH, columns + 1), np.linspace(0, HEIGHT, rows + 1), indexing="ij")
    i, j = (index.ravel() for index in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    a = i * (rows + 1) + j
    b, c, d = a + rows + 1, a + rows + 2, a + 1
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1), faces, "rectangle")


def sphere(subdivisions: int) -> Mesh:
    """Flat triangles with all vertices on the unit sphere."""
    ball = trimesh.creation.icosphere(subdivisions)
    return Mesh(ball.vertices, ball.faces, "sphere")


def rectangle_eigenvalues(first: int) -> FloatArray:
    """π² ((m / width)² + (n / height)²); m and n begin at 0 where the rim is free, at 1 where it is held."""
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
    """Degrees of freedom and largest relative errors of the positive eigenvalues."""
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


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--output", type=Path, default=OUTPUT, help="the picture (%(default)s)")
    options = parser.parse_args()
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
            # Freedoms grow as h⁻², and halving h halves the share: an order p shows as a slope of -p/2.
            order = 2 * np.log(found[-2] / found[-1]) / np.log(freedoms[-1] / freedoms[-2])
            print(f"{title:28} {laplacian:18} h^{order:.1f}   {found[-1]:.1e} at {freedoms[-1]:,}")
            axis.loglog(freedoms, found, marker=marker, color=color, label=laplacian, linewidth=1.2)
        axis.set_title(title)
        axis.set_xlabel("degrees of freedom")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("largest relative error of the lowest eigenvalues")
    axes[0].legend(fontsize="small", loc="lower left")
    figure.savefig(options.output, dpi=110)


if __name__ == "__main__":
    main()
