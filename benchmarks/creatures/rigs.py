# SPDX-License-Identifier: MIT
"""Creatures as Blender objects: a mesh with an Armature modifier.

Needs the `bpy` module. A creature's skeleton becomes bones, its skin weights vertex groups, its written poses
turns of the pose bones; Blender's own skinning then gives the same surface as `Creature.pose`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from mathutils import Quaternion, Vector
from numpy.typing import NDArray

from benchmarks.creatures import Creature
from benchmarks.creatures.skeleton import Skeleton
from shapegoogle_core.mesh import Mesh

__all__ = ["add_creature", "bone_names", "mesh_data", "take_pose"]

FloatArray = NDArray[np.float64]


def bone_names(skeleton: Skeleton) -> list[str]:
    """Name every bone by chain, number and Blender's suffix for the side: "arm.0.L".

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    names : list of str
        One for each bone; unique.
    """
    names = [""] * len(skeleton.bones)
    for chain, bones in skeleton.chains().items():
        side = chain[-2:] if chain.endswith((".L", ".R")) else ""
        for number, bone in enumerate(bones):
            names[bone] = f"{chain.removesuffix(side)}.{number}{side}"
    return names


def mesh_data(mesh: Mesh, name: str) -> Any:
    """Make a smoothly shaded mesh datablock.

    Parameters
    ----------
    mesh : Mesh
    name : str

    Returns
    -------
    data : bpy.types.Mesh
        Vertices and triangles in the same order as in `mesh`.
    """
    data = bpy.data.meshes.new(name)
    data.from_pydata(mesh.vertices.tolist(), [], mesh.faces.tolist())
    data.shade_smooth()
    data.validate()
    return data


def add_creature(creature: Creature, name: str, poses: Sequence[str], collection: Any) -> list[Any]:
    """Add a creature once for every pose; all share one mesh and one armature datablock.

    Parameters
    ----------
    creature : Creature
    name : str
        Name of the datablocks; objects also have the name of their pose: "Horse Gallop".
    poses : sequence of str
        Of `creature.pose_names`.
    collection : bpy.types.Collection
        Must be in the scene.

    Returns
    -------
    skins : list of bpy.types.Object
        The mesh objects, in the order of `poses`; each is the child of its armature object.
    """
    data = mesh_data(creature.rest, name)
    armature: Any = None
    skins: list[Any] = []
    for pose in poses:
        title = f"{name} {pose.title()}"
        if armature is None:
            armature = bpy.data.armatures.new(name)
            armature.display_type = "STICK"
            rig = _linked(f"{title} Rig", armature, collection)
            _add_bones(creature.skeleton, rig)
        else:
            rig = _linked(f"{title} Rig", armature, collection)
            bpy.context.view_layer.update()  # needed for the pose bones
        take_pose(creature, rig, pose)
        skin = _linked(title, data, collection)
        skin.parent = rig
        if not skins:  # vertex groups belong to the shared mesh
            _add_vertex_groups(creature, skin)
        modifier = skin.modifiers.new("Armature", "ARMATURE")
        modifier.object = rig
        modifier.use_deform_preserve_volume = True  # dual quaternions, as in `pose_vertices`
        skins.append(skin)
    return skins


def take_pose(creature: Creature, rig: Any, pose: str) -> None:
    """Pose a creature's armature object.

    Parameters
    ----------
    creature : Creature
    rig : bpy.types.Object
        Armature object of this creature from `add_creature`.
    pose : str
        One of `creature.pose_names`.

    Raises
    ------
    ValueError
        If the creature has no such pose.
    """
    if pose not in creature.pose_names:
        raise ValueError(f"a {creature.kind} has no pose {pose!r}; it has {', '.join(creature.pose_names)}")
    skeleton = creature.skeleton
    angles = np.radians(skeleton.angles(skeleton.poses.get(pose, {})))
    for bone, name, turn in zip(skeleton.bones, bone_names(skeleton), angles, strict=True):
        pose_bone = rig.pose.bones[name]
        # Angles are rotation vectors in rest coordinates; those of a pose bone are in its own.
        own = pose_bone.bone.matrix_local.to_3x3().transposed() @ Vector(turn @ bone.axes)
        pose_bone.rotation_mode = "QUATERNION"
        pose_bone.rotation_quaternion = Quaternion(own)


def _linked(name: str, data: Any, collection: Any) -> Any:
    """Make an object in a collection."""
    item = bpy.data.objects.new(name, data)
    collection.objects.link(item)
    return item


def _add_bones(skeleton: Skeleton, rig: Any) -> None:
    """Add the bones of a skeleton to an armature, in rest pose."""
    names = bone_names(skeleton)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for index, (bone, name) in enumerate(zip(skeleton.bones, names, strict=True)):
        added = rig.data.edit_bones.new(name)
        added.head = bone.head
        added.tail = _bone_tail(skeleton, index)
        # The bone bends about its own x axis.
        added.align_roll(Vector(np.cross(bone.axes[0], added.vector)))
        if bone.parent >= 0:
            added.parent = rig.data.edit_bones[names[bone.parent]]
    bpy.ops.object.mode_set(mode="OBJECT")


def _bone_tail(skeleton: Skeleton, index: int) -> FloatArray:
    """Return the end of a bone: the next bone of its chain, or the extent of its solid along its axis."""
    bone = skeleton.bones[index]
    for other in skeleton.bones:
        if other.parent == index and other.chain == bone.chain:
            return other.head
    twist = -bone.axes[2] if bone.chain.endswith(".R") else bone.axes[2]
    ends = [end for cone in skeleton.cones if cone.bone == index for end in (cone.start, cone.end)]
    reach = max((float(twist @ (end - bone.head)) for end in ends), default=0.0)
    thickness = max((cone.thickness for cone in skeleton.cones if cone.bone == index), default=0.05)
    tail: FloatArray = bone.head + max(reach, thickness) * twist
    return tail


def _add_vertex_groups(creature: Creature, skin: Any) -> None:
    """Add the creature's skin weights to a mesh object, one vertex group for each bone."""
    for name, weights in zip(bone_names(creature.skeleton), creature.weights.T, strict=True):
        group = skin.vertex_groups.new(name=name)
        for vertex in np.flatnonzero(weights):
            group.add([int(vertex)], float(weights[vertex]), "REPLACE")
