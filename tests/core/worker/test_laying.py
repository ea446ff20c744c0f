# SPDX-License-Identifier: MIT
"""Where a mesh has to lie to take the place of another one."""

from __future__ import annotations

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from benchmarks.creatures import make_creature
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, load_model
from shapegoogle_core.worker.laying import lay_meshes


def moved(mesh: Mesh, *, mirror: bool = False, seed: int = 0) -> Mesh:
    """The mesh turned and scaled at another place, its vertices in another order."""
    order = np.random.default_rng(seed).permutation(len(mesh.vertices))
    turn = 3 * Rotation.random(random_state=seed).as_matrix() @ np.diag([-1.0 if mirror else 1.0, 1, 1])
    faces = np.argsort(order)[mesh.faces].astype(np.int32)
    return Mesh(mesh.vertices[order] @ turn.T + [5, 1, -2], faces[:, ::-1] if mirror else faces, "moved")


def deviation(place: FloatArray | None, target: Mesh, mesh: Mesh) -> float:
    """How far the mesh at its place is from the target, in units of the square root of its area."""
    assert place is not None
    points = mesh.vertices @ place[:3, :3].T + place[:3, 3]
    surface = trimesh.Trimesh(target.vertices, target.faces, process=False)
    nearest = trimesh.proximity.closest_point_naive(surface, points[::40])  # type: ignore[no-untyped-call]
    return float(nearest[1].max() / np.sqrt(target.area))


def test_copies_other_meshes_and_mirror_images_take_the_place_and_others_do_not() -> None:
    model: ShapeModel = load_model()
    target = make_creature("horse", 3, vertex_count=1000).pose(0)
    vertices, faces = trimesh.remesh.subdivide(target.vertices, target.faces)  # type: ignore[no-untyped-call]
    finer = Mesh(vertices, faces, "finer")
    assert deviation(lay_meshes(model, [target], moved(target))[0], target, moved(target)) < 2e-3
    other = moved(finer, seed=1)
    assert deviation(lay_meshes(model, [target], other)[0], target, other) < 0.02
    reflected = moved(target, mirror=True, seed=2)
    (place,) = lay_meshes(model, [target], reflected)
    assert deviation(place, target, reflected) < 0.02
    octopus = make_creature("octopus", 3, vertex_count=1000).pose(0)
    assert lay_meshes(model, [target, octopus], moved(octopus, seed=3))[0] is None
