# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of mesh objects of a scene that are the same shape, each around its first mesh.

Meshes are compared, not objects: objects that share a mesh are linked already and no duplicates of each
other. A mesh is compared as it stands in the world at the first object that uses it, before modifiers.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections import defaultdict
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from ..scene.meshes import base_mesh
from ..scene.selection import mesh_objects, split_evaluated
from .congruence import LARGE, TOLERANCE, congruence_steps
from .materials import Materials
from .mesh_data import WorldMesh, differing_steps, world_mesh

if TYPE_CHECKING:
    from shapegoogle_core import Mesh
    from shapegoogle_core.library.duplicates.groups import DuplicateGroup

__all__ = [
    "Collecting",
    "Group",
    "Member",
    "SceneShapes",
    "Solid",
    "collect_shapes",
    "library_groups",
    "scene_groups",
    "similar_groups",
    "solid_shapes",
]


@dataclass(frozen=True)
class Member:
    """An object of the scene, or a shape of a library.

    Attributes
    ----------
    name : str
        The object's; a file's in a group of copied files.
    title : str
        A name that says more than that of the object; empty if there is none.
    library : str
        The .blend file that the object is linked from; empty for one of this file, and in a library.
    source : str
        The file that the shape of a library came from; empty in a scene.
    shape_id : int
        Its number in the library; 0 in a scene.
    scale : float
        Size relative to the first member.
    similarity : float
        To the first member.
    note : str
        What differs from the first member besides the geometry.
    """

    name: str
    library: str = ""
    source: str = ""
    shape_id: int = 0
    scale: float = 1.0
    similarity: float = 1.0
    note: str = ""
    title: str = ""


@dataclass(frozen=True)
class Group:
    """Group of duplicates around its first member, with which the others are compared.

    Attributes
    ----------
    kind : str
        One of `duplicate_properties.KINDS`.
    members : tuple of Member
    meshes : int
        How many meshes (in a library: files or shapes) it has.
    saved_faces : int
        Faces of all meshes but the first.
    saved_bytes : int
        Size of all files but the first, where files are copies.
    linkable : bool
        Whether *Link Data* is meant for it.
    """

    kind: str
    members: tuple[Member, ...]
    meshes: int
    saved_faces: int
    saved_bytes: int = 0
    linkable: bool = False


@dataclass(frozen=True)
class Solid:
    """The objects of one geometry, as plain values: Blender's own may be gone when a worker is done.

    Attributes
    ----------
    members : tuple of Member
    faces : int
    """

    members: tuple[Member, ...]
    faces: int


@dataclass(eq=False)
class _Mesh:
    """A mesh, the objects that use it, and the meshes identical to it."""

    world: WorldMesh
    objects: list[Any]
    scale: float = 1.0
    note: str = ""
    identical: list[_Mesh] = field(default_factory=list)

    @property
    def faces(self) -> int:
        return len(self.world.polygons.sizes)


@dataclass(eq=False)
class _Shape:
    """Congruent meshes: the first one, and those that have another size or other data."""

    first: _Mesh
    variants: list[_Mesh]


@dataclass(frozen=True, eq=False)
class SceneShapes:
    """Shapes of a scene, one entry for each geometry, found by `collect_shapes`.

    Attributes
    ----------
    shapes : list
    skipped : list of str
        Objects that cannot be compared: without vertices or extent, with broken coordinates, or flattened by
        their scale.
    hidden : list of str
        Objects that Blender does not evaluate in the view layer: their places and sizes are not known.
    """

    shapes: list[_Shape]
    skipped: list[str]
    hidden: list[str]


def collect_shapes(context: Any, objects: Sequence[Any]) -> SceneShapes:
    """Compare the meshes of objects.

    Parameters
    ----------
    context : bpy.types.Context
        Its view layer counts.
    objects : sequence of bpy.types.Object
        Others than meshes are left out.

    Returns
    -------
    shapes : SceneShapes
    """
    collection = Collecting(context, objects)
    for _ in collection.steps():
        pass
    return collection.found


class Collecting:
    """Comparison of the meshes of objects, step by step; objects must not change between two steps.

    Parameters
    ----------
    context : bpy.types.Context
    objects : sequence of bpy.types.Object
        As for `collect_shapes`.

    Attributes
    ----------
    found : SceneShapes
        So far.
    total, compared : int
        Number of meshes, and of those that have been compared.
    """

    def __init__(self, context: Any, objects: Sequence[Any]) -> None:
        users: defaultdict[Any, list[Any]] = defaultdict(list)
        evaluated, hidden = split_evaluated(mesh_objects(objects), context)
        for item in sorted(evaluated, key=lambda item: str(item.name)):
            users[item.data].append(item)
        self._users = sorted(users.items(), key=_preference)
        self.found = SceneShapes([], [], sorted(item.name for item in hidden))
        self.total, self.compared = len(self._users), 0
        self._materials = Materials()

    def steps(self) -> Iterator[bool]:
        """Compare one mesh after the other.

        Yields
        ------
        alone : bool
            Whether the step took long by itself, see `..time_slices.next_slice`.
        """
        shapes = self.found.shapes
        # Shapes of the same counts, sorted by their compactness: only near ones can be congruent.
        near: defaultdict[tuple[int, ...], list[tuple[float, int]]] = defaultdict(list)
        for _, items in self._users:
            self.compared += 1
            world = world_mesh(items[0])
            if world is None or not world.polygons.size > 0:
                self.found.skipped.extend(item.name for item in items)
            else:
                if len(world.polygons.vertices) >= LARGE:
                    yield True
                yield from self._place(near[world.polygons.counts], shapes, _Mesh(world, items))
            yield world is not None and len(world.polygons.vertices) >= LARGE

    def _place(
        self, candidates: list[tuple[float, int]], shapes: list[_Shape], mesh: _Mesh
    ) -> Generator[bool, None, None]:
        """Put a mesh to the shape that it is congruent to, or make a new one."""
        polygons = mesh.world.polygons
        compactness = polygons.compactness
        low = bisect_left(candidates, (compactness - 2 * TOLERANCE, -1))
        high = bisect_right(candidates, (compactness + 2 * TOLERANCE, len(shapes)))
        for _, index in sorted(candidates[low:high], key=lambda entry: entry[1]):
            first = shapes[index].first.world
            found = yield from congruence_steps(first.polygons, polygons)
            if found is not None:
                mesh.scale = found.scale
                differences = yield from differing_steps(first, mesh.world, found, self._materials)
                yield from _place(shapes[index], mesh, differences, self._materials)
                return
        insort(candidates, (compactness, len(shapes)))
        shapes.append(_Shape(mesh, []))


def scene_groups(found: SceneShapes) -> list[Group]:
    """List groups of identical meshes, of scaled ones and of such with other data.

    Parameters
    ----------
    found : SceneShapes

    Returns
    -------
    groups : list of Group
        The largest saving first.
    """
    groups = []
    for shape in found.shapes:
        for leader in (shape.first, *shape.variants):
            if leader.identical:
                meshes = [_renewed(leader), *leader.identical]
                groups.append(_group("IDENTICAL", meshes, linkable=True))
        scaled = [mesh for mesh in shape.variants if not _is_one(mesh.scale)]
        other = [mesh for mesh in shape.variants if _is_one(mesh.scale)]
        if scaled:
            linkable = any(not mesh.note for mesh in scaled)
            groups.append(_group("SCALED", [shape.first, *scaled], linkable=linkable))
        if other:
            groups.append(_group("OTHER_DATA", [shape.first, *other]))
    return sorted(groups, key=lambda group: -group.saved_faces)


def solid_shapes(found: SceneShapes) -> Iterator[tuple[Solid, Mesh]]:
    """Read the meshes to describe for `similar_groups`: the first one of each geometry that has faces.

    Parameters
    ----------
    found : SceneShapes

    Yields
    ------
    solid : Solid
    mesh : Mesh
        At world scale, before modifiers. Objects must not change between two of them.
    """
    for shape in found.shapes:
        first = shape.first
        if first.faces:
            members = tuple(Member(item.name, _library(item)) for item in first.objects)
            yield Solid(members, first.faces), base_mesh(first.objects[0])


def similar_groups(solids: Sequence[Solid], groups: Sequence[Sequence[tuple[int, float]]]) -> list[Group]:
    """Convert the result of the core's `group_meshes` to groups of objects.

    Parameters
    ----------
    solids : sequence of Solid
        What each signature was made of.
    groups : sequence of sequence of (int, float)
        Position of the signature and similarity to the first.

    Returns
    -------
    groups : list of Group
        The largest saving first.
    """
    result = []
    for group in groups:
        members = tuple(
            replace(member, similarity=similarity)
            for index, similarity in group
            for member in solids[index].members
        )
        saved = sum(solids[index].faces for index, _ in group[1:])
        result.append(Group("SIMILAR", members, len(group), saved))
    return sorted(result, key=lambda group: -group.saved_faces)


_UNDERSCORES = str.maketrans("- ", "__", "()")


def library_groups(groups: Sequence[DuplicateGroup]) -> list[Group]:
    """Convert the groups of a library to those of the panel.

    Parameters
    ----------
    groups : sequence of DuplicateGroup

    Returns
    -------
    groups : list of Group
        In the same order.
    """
    return [
        Group(
            group.title.upper().translate(_UNDERSCORES),
            tuple(
                Member(
                    member.object_name or member.name,
                    source=member.source,
                    shape_id=member.shape_id,
                    scale=member.scale,
                    similarity=member.similarity,
                    title=member.name if member.name != member.object_name else "",
                )
                for member in group.members
            ),
            len(group.members),
            group.saved_faces,
            group.saved_bytes,
        )
        for group in groups
    ]


def _preference(entry: tuple[Any, list[Any]]) -> tuple[bool, int, str]:
    """Which mesh stands first in its group: one of this file, then the most used, then by name."""
    data, items = entry
    return data.library is not None, -len(items), items[0].name


def _place(
    shape: _Shape, mesh: _Mesh, differences: list[str], materials: Materials
) -> Generator[bool, None, None]:
    """Put a mesh to those that it equals in size and data, or beside them."""
    mesh.note = ", ".join(differences)
    if _is_one(mesh.scale) and not differences:
        shape.first.identical.append(mesh)
        return
    for variant in shape.variants:
        if not _is_one(mesh.scale / variant.scale):
            continue
        found = yield from congruence_steps(variant.world.polygons, mesh.world.polygons)
        if found is None:
            continue
        if not (yield from differing_steps(variant.world, mesh.world, found, materials)):
            mesh.scale, mesh.note = 1.0, ""
            variant.identical.append(mesh)
            return
    shape.variants.append(mesh)


def _renewed(mesh: _Mesh) -> _Mesh:
    """Leader of a group of its own: size and data are compared with its own."""
    return _Mesh(mesh.world, mesh.objects)


def _group(kind: str, meshes: Sequence[_Mesh], *, linkable: bool = False) -> Group:
    members = tuple(
        Member(item.name, _library(item), scale=mesh.scale, note=mesh.note)
        for mesh in meshes
        for item in mesh.objects
    )
    return Group(kind, members, len(meshes), sum(mesh.faces for mesh in meshes[1:]), linkable=linkable)


def _is_one(scale: float) -> bool:
    return abs(scale - 1) <= TOLERANCE


def _library(item: Any) -> str:
    return "" if item.library is None else str(item.library.filepath)
