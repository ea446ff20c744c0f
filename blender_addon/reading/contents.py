# SPDX-License-Identifier: GPL-3.0-or-later
"""The shapes of the open .blend file, which is read and never saved.

It imports nothing but bpy and its neighbours, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import bpy

from .arrays import MeshWriter, what_is_empty
from .assets import catalogs_for
from .entries import Assembly, Entry
from .instancers import Instance, InstanceCollector, show_realized
from .portions import Portions, Together, computed_faces, evaluated_together
from .records import SHAPE_TYPES, State, group_of, item_of
from .sharing import SharedMeshes

__all__ = ["MOST_FACES_AT_ONCE", "MOST_OBJECTS_AT_ONCE", "read_contents"]

MOST_FACES_AT_ONCE = 1_000_000
"""Faces that objects evaluated together should have, by those before them; one alone may have more."""
MOST_OBJECTS_AT_ONCE = 64
"""Objects that are evaluated together: subdivision needs megabytes for each besides its faces."""


def read_contents(
    path: Path,
    output: BinaryIO,
    *,
    assets_only: bool = False,
    frames: Sequence[int] = (),
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> dict[str, Any]:
    """Write the meshes of the open file, and describe its shapes.

    Parameters
    ----------
    path : Path
        Of the file.
    output : file object
        For the arrays.
    assets_only : bool, optional
        Only objects and collections marked as assets, if there are any.
    frames : sequence of int, optional
        Frames at which objects are read; each pose is a shape. The current frame by default.
    progress : callable, optional
        Called after each portion with the number of objects that have been evaluated, and that of all.

    Returns
    -------
    answer : dict
        "meshes", "shapes", "problems", "left_out" and "linked".
    """
    return _Contents(path, output, assets_only, list(frames), progress).read()


class _Contents:
    def __init__(
        self,
        path: Path,
        output: BinaryIO,
        assets_only: bool,
        frames: list[int],
        progress: Callable[[int, int], None],
    ) -> None:
        self._writer = MeshWriter(output)
        self._progress = progress
        # Objects that have been evaluated, and all of them: those that instance others twice.
        self._done = self._total = 0
        self._frames = frames or [bpy.context.scene.frame_current]
        self._problems: list[str] = []
        self._left_out: Counter[str] = Counter()
        self._shown = {
            item.session_uid
            for scene in bpy.data.scenes
            for layer in scene.view_layers
            for item in layer.objects
        }
        catalogs = catalogs_for(path)
        # By name, also where the file keeps them in another order.
        self._objects = {item.session_uid: item for item in sorted(bpy.data.objects, key=_by_name)}
        self._items = {uid: item_of(item, catalogs) for uid, item in self._objects.items()}
        self._collections = sorted(bpy.data.collections, key=_by_name)
        self._groups = [group_of(collection, catalogs) for collection in self._collections]
        local = [item for item in self._items.values() if item.is_local]
        marked = [item for item in local if self._objects[item.uid].asset_data is not None]
        some = assets_only and bool(marked or any(group.is_asset for group in self._groups))
        listed = marked if some else local
        self._chosen = {item.uid: None for item in listed if item.has_mesh}
        self._carriers = [item for item in listed if item.carries]
        self._left_out.update(item.kind for item in listed if not item.has_mesh and not item.carries)

    def read(self) -> dict[str, Any]:
        # Before anything is unhidden, since what is hidden is not instanced either.
        show_realized(self._objects[item.uid] for item in self._carriers)
        instances, wholes = self._instances()
        every = [one for own in (*instances.values(), *wholes.values()) for one in own]
        leaves = list({one.uid: None for one in every if one.mesh is None})
        read = [self._objects[uid] for uid in dict.fromkeys([*self._chosen, *leaves])]
        # Twice each that may be shown more than once: the content of others need not be known.
        again = [self._objects[uid] for uid in (list(self._chosen) if len(self._frames) > 1 else leaves)]
        meshes: SharedMeshes[Entry] = SharedMeshes([*read, *again])
        assembly = Assembly(
            self._items.values(), self._groups, meshes, self._writer.faces, self._shown, self._chosen
        )
        for frame, states in self._evaluated(read, meshes, instances):
            if frame == self._frames[0]:
                steps = assembly.add_all(self._carriers, instances, wholes, states)
            else:
                steps = assembly.add_objects(states, frame, self._frames[0])
            for _ in steps:
                pass
        linked = self._linked_files()
        return {
            "meshes": self._writer.counts(),
            "shapes": [entry.to_json() for entry in assembly.entries if entry.placements],
            "problems": self._problems,
            "left_out": dict(self._left_out + assembly.left_out),
            "linked": linked,
        }

    def _instances(self) -> tuple[dict[int, list[Instance]], dict[int, list[Instance]]]:
        """Collect what is instanced, and what is in the collections that are assets."""
        wholes = {}
        for collection, group in zip(self._collections, self._groups, strict=True):
            if group.is_asset:
                empty = bpy.data.objects.new("Shape Google", None)
                empty.instance_type, empty.instance_collection = "COLLECTION", collection
                empty.location = collection.instance_offset
                wholes[group.uid] = empty
        carriers = [self._objects[item.uid] for item in self._carriers]
        for item in carriers:
            item.hide_viewport = False
        collector = InstanceCollector(
            SHAPE_TYPES,
            self._writer.write_part,
            lambda item: self._items[item.session_uid].is_local,
        )
        portions = Portions(MOST_OBJECTS_AT_ONCE, MOST_FACES_AT_ONCE)
        waiting = deque(evaluated_together([*carriers, *wholes.values()]))
        self._total = sum(group.weight for group in waiting) + len(self._chosen)
        while waiting:
            some = portions.take(waiting)
            depsgraph, scene = _evaluate(some, self._frames[0])
            collector.collect(depsgraph)
            portions.note(collector.faces + sum(computed_faces(item, depsgraph) for item in some))
            bpy.data.scenes.remove(scene)
            self._count(portions.weight)
        self._left_out["further instance"] += collector.further
        inside = {uid: collector.of.pop(empty.session_uid, []) for uid, empty in wholes.items()}
        bpy.data.batch_remove(list(wholes.values()))
        return collector.of, inside

    def _evaluated(
        self, objects: list[Any], meshes: SharedMeshes[Entry], instances: dict[int, list[Instance]]
    ) -> Iterator[tuple[int, dict[int, State]]]:
        """Yield the meshes of objects at each frame, also of those that are hidden or in no scene.

        They are evaluated in scenes of their own, where everything is visible: so many at a time that their
        meshes, which may have become a thousand times as large by subdivision, do not fill the memory.
        Objects they depend on (armatures, targets of modifiers) are evaluated without being in it.
        """
        for item in objects:
            item.hide_viewport = False
        known: dict[tuple[int, bytes], int] = {}
        found: dict[int, dict[int, State]] = {frame: {} for frame in self._frames}
        # One ball of a family has the mesh of all: they belong together.
        together = [item for item in objects if item.type == "META"]
        waiting = deque(Together((item,), 1) for item in objects if item.type != "META")
        if together:
            self._evaluate_some(together, meshes, instances, known, found)
        # Besides those that were chosen, objects that others instance.
        self._total = self._done + len(objects)
        self._count(len(together))
        portions = Portions(MOST_OBJECTS_AT_ONCE, MOST_FACES_AT_ONCE)
        while waiting:
            some = portions.take(waiting)
            portions.note(self._evaluate_some(some, meshes, instances, known, found))
            self._count(len(some))
        for frame, states in found.items():
            # In the order of the objects.
            yield frame, {uid: states[uid] for item in objects if (uid := item.session_uid) in states}

    def _count(self, evaluated: int) -> None:
        self._done += evaluated
        self._progress(self._done, self._total)

    def _evaluate_some(
        self,
        objects: list[Any],
        meshes: SharedMeshes[Entry],
        instances: dict[int, list[Instance]],
        known: dict[tuple[int, bytes], int],
        found: dict[int, dict[int, State]],
    ) -> int:
        """Add the states of some objects at each frame; returns how many faces they have at the first."""
        depsgraph, scene = _evaluate(objects, self._frames[0])
        for frame, states in found.items():
            is_first = frame == self._frames[0]
            if not is_first:
                scene.frame_set(frame)
                depsgraph = scene.view_layers[0].depsgraph
                depsgraph.update()
            for item in objects:
                uid = item.session_uid
                try:
                    state = evaluated_state(item, depsgraph, meshes, self._writer, known)
                except RuntimeError as error:
                    if self._items[uid].kind == "metaball":
                        state = None
                    else:
                        if is_first:
                            self._problems.append(
                                f"{item.name!r} has no mesh once evaluated ({error}); check its modifiers"
                            )
                        continue
                if state is not None:
                    states[uid] = state
                elif is_first and uid in self._chosen and uid not in instances:
                    self._left_out[what_is_empty(item, self._items[uid].kind)] += 1
        bpy.data.scenes.remove(scene)
        first = found[self._frames[0]]
        read = [first[item.session_uid].mesh for item in objects if item.session_uid in first]
        return sum(self._writer.faces[mesh] for mesh in read)

    def _linked_files(self) -> list[str]:
        """Return the files that have the linked objects and meshes; counts what is missing."""
        objects = [item for item in bpy.data.objects if item.library is not None and item.type in SHAPE_TYPES]
        paths: dict[str, None] = {}
        for block in (*objects, *(mesh for mesh in bpy.data.meshes if mesh.library is not None)):
            library = block.library
            path = Path(bpy.path.abspath(library.filepath, library=library.library)).resolve()
            if path.is_file():
                paths[str(path)] = None
            elif block in objects:
                self._left_out["object of a missing file"] += 1
        return list(paths)


def evaluated_state(
    item: Any,
    depsgraph: Any,
    meshes: SharedMeshes[Entry],
    writer: MeshWriter,
    known: dict[tuple[int, bytes], int],
) -> State | None:
    """Write the mesh of an object, unless another one has shown it.

    Parameters
    ----------
    item : bpy.types.Object
    depsgraph : bpy.types.Depsgraph
    meshes : SharedMeshes
    writer : MeshWriter
    known : dict
        Numbers of the meshes that were written, by the numbers of objects' data and their contents.

    Returns
    -------
    state : State or None
        None without a surface.

    Raises
    ------
    RuntimeError
        If Blender has no mesh of it.
    """
    evaluated = item.evaluated_get(depsgraph)
    matrix, content, data = evaluated.matrix_world.copy(), meshes.content(evaluated), item.data.session_uid
    if content is None or (data, content) not in known:
        positions, faces = writer.read(evaluated)
        if not positions:
            return None
        content = meshes.read(evaluated, positions, faces)
        if not content:
            return State(matrix, content, writer.write(positions, faces))
        if (data, content) not in known:
            known[data, content] = writer.write(positions, faces)
    return State(matrix, content, known[data, content])


def _evaluate(objects: list[Any], frame: int) -> tuple[Any, Any]:
    """Evaluate objects in a new scene; returns its depsgraph and the scene."""
    scene = bpy.data.scenes.new("Shape Google")
    scene.frame_set(frame)
    for item in objects:
        scene.collection.objects.link(item)
        item.update_tag()  # Blender 4.2 and 4.5 leave the matrix of another scene's object as it was
    layer = scene.view_layers[0]
    layer.update()
    depsgraph = layer.depsgraph
    depsgraph.update()
    return depsgraph, scene


def _by_name(block: Any) -> str:
    return str(block.name)
