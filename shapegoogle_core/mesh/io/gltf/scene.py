# SPDX-License-Identifier: MIT
"""The scene of a glTF: every mesh in the places of its nodes, skinned ones in the pose of their joints.

Which scene: the default one; the first if none is the default, as in viewers. If there is none, or it shows
no mesh, all nodes count. Meshes that no node shows are read only if no node shows any.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, check_face_count, check_point_count
from shapegoogle_core.mesh.io.gltf.accessors import accessor_count, read_floats
from shapegoogle_core.mesh.io.gltf.container import Document
from shapegoogle_core.mesh.io.gltf.extensions import INSTANCING
from shapegoogle_core.mesh.io.gltf.json_object import JsonObject
from shapegoogle_core.mesh.io.gltf.meshes import Part, announced_size, read_parts
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_scene"]


@dataclass(frozen=True)
class _Shown:
    """A mesh that a node shows."""

    mesh: JsonObject
    node: int | None = None  # None: no node shows it, so it stays where it is


def read_scene(document: Document) -> Polygons:
    """Read all meshes of a glTF's scene into one.

    Parameters
    ----------
    document : Document

    Returns
    -------
    polygons : Polygons
        Points alone if there are no triangles.

    Raises
    ------
    FormatError
        If the file is damaged, shows nothing but lines, or has too many faces.
    """
    parents = _parents(document)
    roots = _scene_roots(document)
    for root in roots:
        parents[root] = None  # a scene begins there, whatever is above: some programs leave an empty node
    shown = _shown_meshes(document, roots, parents)
    sizes = {item.mesh.place: announced_size(document, item.mesh) for item in shown}
    faces, points = 0, 0
    for item in shown:
        copies = _instance_count(document, item)
        faces += sizes[item.mesh.place][0] * copies
        points += sizes[item.mesh.place][1] * copies
    check_face_count(faces, document.file.max_faces)
    if not faces:
        check_point_count(points, document.file.max_faces)
    shown = [item for item in shown if sizes[item.mesh.place][0 if faces else 1]]
    places = _world_matrices(document, parents)
    reader = _PartReader(document)
    placed_parts = [part for item in shown for part in _placed(document, item, places, reader)]
    surfaces = [part for part in placed_parts if len(part.faces)]
    if surfaces:
        starts = np.cumsum([0, *(len(part.vertices) for part in surfaces)])
        triangles = [part.faces + start for part, start in zip(surfaces, starts, strict=False)]
        return Polygons.from_triangles(
            np.concatenate([part.vertices for part in surfaces]), np.concatenate(triangles)
        )
    if not placed_parts:
        raise FormatError(
            "shows no triangles and no points: only lines, or no mesh at all; export it with its surfaces"
        )
    return Polygons.from_points(np.concatenate([part.vertices for part in placed_parts]))


def _parents(document: Document) -> list[int | None]:
    """Return the parent of each node; `FormatError` if one has two, or is below itself."""
    nodes = document.all("nodes")
    parents: list[int | None] = [None] * len(nodes)
    for index, node in enumerate(nodes):
        for child in node.wholes("children"):
            document.item("nodes", child, node)
            if parents[child] is not None:
                raise FormatError(
                    f"has nodes[{child}] below two nodes, which glTF does not allow; export it again"
                )
            parents[child] = index
    sound = np.zeros(len(nodes), bool)
    for start in range(len(nodes)):
        chain = set[int]()
        index_above: int | None = start
        while index_above is not None and not sound[index_above]:
            if index_above in chain:
                raise FormatError(f"has nodes[{start}] below itself; export it again")
            chain.add(index_above)
            index_above = parents[index_above]
        sound[list(chain)] = True
    return parents


def _scene_roots(document: Document) -> list[int]:
    scenes = document.all("scenes")
    if not scenes:
        return []
    scene = document.item("scenes", document.root.whole("scene", 0), document.root)
    for root in scene.wholes("nodes"):
        document.item("nodes", root, scene)
    return scene.wholes("nodes")


def _shown_meshes(
    document: Document, scene_roots: Sequence[int], parents: Sequence[int | None]
) -> list[_Shown]:
    """List the meshes of the scene; see the top of this file."""
    roots = [index for index, parent in enumerate(parents) if parent is None]
    shown = _below(document, scene_roots) or _below(document, roots)
    return shown or [_Shown(mesh) for mesh in document.all("meshes")]


def _below(document: Document, roots: Iterable[int]) -> list[_Shown]:
    """List the meshes of some nodes and of all nodes below them."""
    shown, seen, waiting = [], set[int](), list(roots)[::-1]
    while waiting:
        index = waiting.pop()
        if index in seen:
            continue  # named twice by its scene
        seen.add(index)
        node = document.all("nodes")[index]
        if node.has("mesh"):
            shown.append(_Shown(document.item("meshes", node.whole("mesh"), node), index))
        waiting.extend(node.wholes("children")[::-1])
    return shown


def _world_matrices(document: Document, parents: Sequence[int | None]) -> FloatArray:
    """Return the matrix of each node, from its coordinates to those of the scene; (n, 4, 4)."""
    nodes = document.all("nodes")
    matrices = np.array([_local_matrix(node) for node in nodes]).reshape(-1, 4, 4)
    done = np.zeros(len(nodes), bool)
    for start in range(len(nodes)):
        chain: list[int] = []
        index: int | None = start
        while index is not None and not done[index]:
            chain.append(index)
            index = parents[index]
        for below in reversed(chain):
            parent = parents[below]
            if parent is not None:
                matrices[below] = matrices[parent] @ matrices[below]
            done[below] = True
    return matrices


def _local_matrix(node: JsonObject) -> FloatArray:
    if node.has("matrix"):
        return node.numbers("matrix", 16).reshape(4, 4).T  # column by column in the file
    shift = node.numbers("translation", 3) if node.has("translation") else np.zeros(3)
    turn = node.numbers("rotation", 4) if node.has("rotation") else np.array([0.0, 0, 0, 1])
    scale = node.numbers("scale", 3) if node.has("scale") else np.ones(3)
    matrix: FloatArray = _matrices(shift[None], turn[None], scale[None])[0]
    return matrix


def _matrices(shifts: FloatArray, turns: FloatArray, scales: FloatArray) -> FloatArray:
    """Return matrices that scale first, then turn by quaternions (x, y, z, w), then shift; (n, 4, 4)."""
    lengths = np.linalg.norm(turns, axis=1, keepdims=True)
    x, y, z, w = np.where(lengths > 0, turns / np.where(lengths > 0, lengths, 1), [0, 0, 0, 1]).T
    matrices = np.zeros((len(shifts), 4, 4))
    matrices[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1)
    matrices[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1)
    matrices[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1)
    matrices[:, :3, :3] *= scales[:, None, :]
    matrices[:, :3, 3] = shifts
    matrices[:, 3, 3] = 1
    return matrices


def _instancing(document: Document, item: _Shown) -> JsonObject | None:
    """Return the attributes of a node's instances; None if it shows its mesh once."""
    if item.node is None:
        return None
    extensions = document.all("nodes")[item.node].object("extensions")
    return extensions.object(INSTANCING).object("attributes") if extensions.has(INSTANCING) else None


def _instance_count(document: Document, item: _Shown) -> int:
    attributes = _instancing(document, item)
    if attributes is None:
        return 1
    names = [name for name in ("TRANSLATION", "ROTATION", "SCALE") if attributes.has(name)]
    counts = {accessor_count(document, attributes.whole(name), attributes) for name in names}
    if len(counts) > 1:
        raise DamagedError(f"has different numbers of instances in {attributes.place}")
    return counts.pop() if counts else 1


def _instance_matrices(document: Document, item: _Shown) -> FloatArray:
    """Return the matrices of a node's instances, in its coordinates; (n, 4, 4)."""
    attributes = _instancing(document, item)
    if attributes is None:
        return np.eye(4)[None]
    count = _instance_count(document, item)
    values = []
    for name, kind, default in (
        ("TRANSLATION", "VEC3", [0, 0, 0]),
        ("ROTATION", "VEC4", [0, 0, 0, 1]),
        ("SCALE", "VEC3", [1, 1, 1]),
    ):
        if attributes.has(name):
            values.append(read_floats(document, attributes.whole(name), kind, attributes))
        else:
            values.append(np.tile(np.array(default, np.float64), (count, 1)))
    return _matrices(*values)


class _PartReader:
    """Reads the parts of a mesh once for all nodes that show them in the same form."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._parts: dict[tuple[str, bytes, bool], list[Part]] = {}

    def read(self, mesh: JsonObject, weights: FloatArray, with_skin: bool) -> list[Part]:
        key = mesh.place, weights.tobytes(), with_skin
        if key not in self._parts:
            self._parts[key] = read_parts(self._document, mesh, weights, with_skin)
        return self._parts[key]


def _placed(document: Document, item: _Shown, places: FloatArray, reader: _PartReader) -> list[Part]:
    """Put copies of the parts of a mesh in all its places."""
    node = JsonObject({}, "") if item.node is None else document.all("nodes")[item.node]
    weights = (node if node.has("weights") else item.mesh).numbers("weights")
    parts = reader.read(item.mesh, weights, node.has("skin"))
    joints = _joint_matrices(document, node, places) if node.has("skin") else np.empty((0, 4, 4))
    matrices = _instance_matrices(document, item)
    if item.node is not None:
        matrices = places[item.node] @ matrices
    placed = []
    for part in parts:
        if part.joints.shape[1]:
            placed.append(_posed(part, joints))  # only the joints count, not the node
        else:
            placed.extend(_moved(part, matrix) for matrix in matrices)
    return placed


def _moved(part: Part, matrix: FloatArray) -> Part:
    if np.array_equal(matrix, np.eye(4)):
        return part
    with np.errstate(invalid="ignore", over="ignore"):  # such points are dropped or refused later
        vertices = part.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    mirrored = np.linalg.det(matrix[:3, :3]) < 0  # its faces would come out inside out
    return replace(part, vertices=vertices, faces=part.faces[:, ::-1] if mirrored else part.faces)


def _joint_matrices(document: Document, node: JsonObject, places: FloatArray) -> FloatArray:
    """Return the matrix of each joint of a node's skin, from the mesh to the scene; (j, 4, 4)."""
    skin = document.item("skins", node.whole("skin"), node)
    joints = skin.wholes("joints")
    if not joints:
        raise DamagedError(f"has no joints in {skin.place}")
    for joint in joints:
        document.item("nodes", joint, skin)
    matrices = places[joints]
    if skin.has("inverseBindMatrices"):
        inverse = read_floats(document, skin.whole("inverseBindMatrices"), "MAT4", skin)
        if len(inverse) < len(joints):
            raise DamagedError(
                f"has {len(inverse):,} inverse bind matrices for {len(joints):,} joints in {skin.place}"
            )
        matrices = matrices @ inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    return matrices


def _posed(part: Part, matrices: FloatArray) -> Part:
    """Move each vertex by the mean of its joints' matrices, weighted by their influences."""
    weights = np.where(np.isfinite(part.weights), part.weights, 0)
    used = weights != 0
    if used.any() and part.joints[used].max() >= len(matrices):
        raise DamagedError(
            f"names joint {part.joints[used].max()}, counted from 0, of {len(matrices)} in {part.place}"
        )
    joints = np.where(used, part.joints, 0)
    sums = weights.sum(axis=1, keepdims=True)
    # A vertex without any influence follows the first joint that it names, as in viewers.
    first = np.zeros_like(weights)
    first[:, 0] = 1
    joints[:, 0] = np.where(sums[:, 0] != 0, joints[:, 0], np.minimum(part.joints[:, 0], len(matrices) - 1))
    weights = np.where(sums != 0, weights / np.where(sums != 0, sums, 1), first)
    vertices = np.zeros_like(part.vertices)
    for chosen, share in zip(joints.T, weights.T, strict=True):
        with np.errstate(invalid="ignore", over="ignore"):
            moved = np.einsum("nij,nj->ni", matrices[chosen, :3, :3], part.vertices) + matrices[chosen, :3, 3]
            vertices += share[:, None] * moved
    mirrored = np.linalg.det(matrices[:, :3, :3]) < 0
    flipped = (weights * mirrored[joints]).sum(axis=1)[part.faces].mean(axis=1) > 0.5
    faces = np.where(flipped[:, None], part.faces[:, ::-1], part.faces) if len(part.faces) else part.faces
    return replace(part, vertices=vertices, faces=faces)
