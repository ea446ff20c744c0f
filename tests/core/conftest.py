# SPDX-License-Identifier: MIT
"""Shapes whose spectrum is known, and the evaluation meshes where they are at hand."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from shapegoogle_core.mesh import Mesh


def make_sphere(subdivisions: int) -> Mesh:
    sphere = trimesh.creation.icosphere(subdivisions)
    return Mesh(sphere.vertices, sphere.faces, name="sphere")


def make_grid(columns: int, rows: int, wrap: bool = False) -> np.ndarray:
    """Faces of a grid of `columns` × `rows` squares, each cut in two; (columns + 1)(rows + 1) vertices, or
    columns · rows where the sides are glued."""
    width, height = (columns, rows) if wrap else (columns + 1, rows + 1)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    right, up = (i + 1) % width, (j + 1) % height
    a, b, c, d = i * height + j, right * height + j, right * height + up, i * height + up
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def make_rectangle(width: float, height: float, cells: int) -> Mesh:
    columns, rows = cells, max(1, round(cells * height / width))
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return Mesh(vertices, make_grid(columns, rows), name="rectangle")


def make_flat_torus(width: float, height: float, cells: int) -> Mesh:
    """A flat torus, folded twice like a paper bag: four layers in the plane, glued at their rims.

    Folding along grid lines changes no length, so its Laplacian is that of the torus.
    """
    columns, rows = 2 * (cells // 2), 2 * max(1, round(cells * height / width / 2))
    fold_x = np.abs((np.arange(columns) * width / columns) - width / 2)
    fold_y = np.abs((np.arange(rows) * height / rows) - height / 2)
    x, y = np.meshgrid(fold_x, fold_y, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return Mesh(vertices, make_grid(columns, rows, wrap=True), name="flat torus")


def make_bumpy(subdivisions: int = 3, seed: int = 0) -> Mesh:
    """A sphere with smooth random bumps: no symmetry, hence no multiple eigenvalues."""
    sphere = trimesh.creation.icosphere(subdivisions)
    random = np.random.default_rng(seed)
    centers = random.standard_normal((8, 3))
    centers /= np.linalg.norm(centers, axis=1, keepdims=True)
    heights = random.uniform(-0.3, 0.6, 8)
    bumps = np.exp(-8 * (1 - sphere.vertices @ centers.T)) @ heights
    return Mesh(sphere.vertices * (1 + bumps)[:, None], sphere.faces, name="bumpy sphere")


@pytest.fixture(scope="session")
def bumpy() -> Mesh:
    return make_bumpy()


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The evaluation meshes; tests that need them skip where they are absent."""
    default = Path(__file__).resolve().parents[3] / "shared" / "data"
    folder = Path(os.environ.get("SHAPEGOOGLE_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no evaluation data in {folder}; set SHAPEGOOGLE_DATA")
    return folder


def write_mesh(path: Path, seed: int = 0, subdivisions: int = 2) -> Path:
    """Write a lumpy ellipsoid, another one for each seed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(seed)
    mesh = trimesh.creation.icosphere(subdivisions)
    centers = random.standard_normal((4, 3))
    centers /= np.linalg.norm(centers, axis=1, keepdims=True)
    bumps = np.exp(-6 * (1 - mesh.vertices @ centers.T)) @ random.uniform(0, 0.7, 4)
    mesh.vertices = mesh.vertices * (1 + bumps)[:, None] * random.uniform(0.6, 1.8, 3)
    mesh.export(path)
    return path


@pytest.fixture(scope="session")
def make_mesh() -> Callable[..., Path]:
    """See `write_mesh`."""
    return write_mesh


class Shapes:
    """The makers of this file, for tests that want another size."""

    sphere = staticmethod(make_sphere)
    rectangle = staticmethod(make_rectangle)
    flat_torus = staticmethod(make_flat_torus)
    bumpy = staticmethod(make_bumpy)


@pytest.fixture(scope="session")
def shapes() -> type[Shapes]:
    """Makers of shapes whose spectrum is known."""
    return Shapes
