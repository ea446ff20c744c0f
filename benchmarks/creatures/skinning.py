# SPDX-License-Identifier: MIT
"""Skin weights and dual-quaternion skinning.

Dual quaternions (Kavan et al. 2008) keep the volume of twisted joints, which linear blending would
collapse.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import splu

from benchmarks.creatures.skeleton import Skeleton
from benchmarks.creatures.surface import cone_distances
from shapegoogle_core.mesh import Mesh, face_areas

__all__ = ["pose_vertices", "skin_weights"]

FloatArray = NDArray[np.float64]

# Width of the transition between two bones, in local radii of the limb.
_TRANSITION = 0.8


def skin_weights(skeleton: Skeleton, mesh: Mesh) -> FloatArray:
    """Compute the weights of every bone at every vertex.

    Every vertex is assigned to the bone with the nearest solid; the labels then diffuse along the surface,
    over a distance that grows with the limb's thickness. Because diffusion follows the surface, a leg never
    moves with the other leg, however close it is.

    Parameters
    ----------
    skeleton : Skeleton
    mesh : Mesh
        The skeleton's skin in rest pose.

    Returns
    -------
    weights : (n, bones) array
        Non-negative, rows sum to 1.
    """
    points = tuple(mesh.vertices.T)
    depths = np.stack([cone_distances(cone, points) for cone in skeleton.cones])
    sizes = np.array(
        [(cone.start_radius + cone.end_radius) / 2 * np.cbrt(cone.stretch.prod()) for cone in skeleton.cones]
    )
    nearest = depths.argmin(axis=0)
    bones = np.array([cone.bone for cone in skeleton.cones])[nearest]
    labels = np.zeros((len(mesh.vertices), len(skeleton.bones)))
    labels[np.arange(len(labels)), bones] = 1.0

    mass, stiffness = _surface_laplacian(mesh, (_TRANSITION * sizes[nearest]) ** 2)
    # Two half steps are smoother than one step.
    solver = splu(csc_array(diags_array(mass) + 0.5 * stiffness))
    weights: FloatArray = solver.solve(mass[:, None] * solver.solve(mass[:, None] * labels))
    weights = np.maximum(weights, 0)
    weights[weights < 1e-3] = 0
    weights /= weights.sum(axis=1, keepdims=True)
    return weights


def _surface_laplacian(mesh: Mesh, times: FloatArray) -> tuple[FloatArray, csc_array]:
    """Compute lumped vertex areas, and cotangent stiffness times a varying diffusion time."""
    count = len(mesh.vertices)
    rows, columns, values = [], [], []
    for corner in range(3):
        tip, a, b = (mesh.faces[:, (corner + step) % 3] for step in range(3))
        u, v = mesh.vertices[a] - mesh.vertices[tip], mesh.vertices[b] - mesh.vertices[tip]
        twice_area: FloatArray = np.linalg.norm(np.cross(u, v), axis=1)
        cotangent = np.einsum("ij,ij->i", u, v) / np.maximum(twice_area, np.finfo(float).tiny)
        # Obtuse corners would make weights negative; with a lower bound diffusion stays an average.
        rows.append(a)
        columns.append(b)
        values.append(0.5 * np.clip(cotangent, 0.01, 10) * (times[a] + times[b]) / 2)
    edges = coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(count, count)
    )
    adjacency = csc_array(edges + edges.T)
    stiffness = csc_array(diags_array(np.asarray(adjacency.sum(axis=1)).ravel()) - adjacency)
    mass = np.bincount(mesh.faces.ravel(), np.repeat(face_areas(mesh) / 3, 3), minlength=count)
    return mass.astype(np.float64), stiffness


def _quaternion_product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute the Hamilton product of quaternions (w, x, y, z)."""
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], vector])


def _rotate(quaternion: FloatArray, vectors: FloatArray) -> FloatArray:
    """Rotate vectors (…, 3) by unit quaternions (…, 4)."""
    scalar, axis = quaternion[..., :1], quaternion[..., 1:]
    across = 2 * np.cross(axis, vectors)
    rotated: FloatArray = vectors + scalar * across + np.cross(axis, across)
    return rotated


def _bone_motions(skeleton: Skeleton, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute forward kinematics: rotation (quaternion) and translation of every bone from rest to pose."""
    rotations = np.empty((len(skeleton.bones), 4))
    translations = np.empty((len(skeleton.bones), 3))
    for index, bone in enumerate(skeleton.bones):
        turn = np.radians(angles[index]) @ bone.axes
        angle = float(np.linalg.norm(turn))
        # np.sinc is sin(πx)/(πx), which has the right limit at 0.
        local = np.concatenate([[np.cos(angle / 2)], turn * np.sinc(angle / (2 * np.pi)) / 2])
        shift = bone.head - _rotate(local, bone.head)
        if bone.parent < 0:
            rotations[index], translations[index] = local, shift
        else:
            parent = rotations[bone.parent]
            rotations[index] = _quaternion_product(parent, local)
            translations[index] = _rotate(parent, shift) + translations[bone.parent]
    return rotations, translations


def pose_vertices(
    skeleton: Skeleton, weights: FloatArray, vertices: FloatArray, angles: FloatArray
) -> FloatArray:
    """Move vertices from the rest pose to a pose.

    Parameters
    ----------
    skeleton : Skeleton
    weights : (n, bones) array
    vertices : (n, 3) array
        In rest pose.
    angles : (bones, 3) array
        Bend, swing and twist of every bone in degrees.

    Returns
    -------
    posed : (n, 3) array
    """
    rotations, translations = _bone_motions(skeleton, angles)
    pure = np.concatenate([np.zeros((len(translations), 1)), translations], axis=1)
    duals = 0.5 * np.stack([_quaternion_product(t, q) for t, q in zip(pure, rotations, strict=True)])
    # Children continue their parent's quaternion, so signs agree along the skeleton and blends take the
    # shorter way.
    blended = weights @ np.concatenate([rotations, duals], axis=1)
    real, dual = blended[:, :4], blended[:, 4:]
    length = np.linalg.norm(real, axis=1, keepdims=True)
    real, dual = real / length, dual / length
    shift = 2 * (real[:, :1] * dual[:, 1:] - dual[:, :1] * real[:, 1:] + np.cross(real[:, 1:], dual[:, 1:]))
    posed: FloatArray = _rotate(real, vertices) + shift
    return posed
