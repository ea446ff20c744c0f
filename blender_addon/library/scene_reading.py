# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the open scene: its shapes as they are now, saved or not.

All meshes are written into a file, as the Blender that reads files does it. That is work for the main thread,
which does it in slices, so that the window goes on answering.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import bpy

from ..reading.arrays import MeshWriter, what_is_empty
from ..reading.assets import catalogs_for
from ..reading.contents import evaluated_state
from ..reading.entries import Assembly, Entry
from ..reading.instancers import Instance, InstanceCollector
from ..reading.records import SHAPE_TYPES, Group, Item, State, group_of, item_of
from ..reading.sharing import SharedMeshes
from ..scene.selection import split_evaluated
from ..translation import tr
from .open_file import is_unsaved, open_source

if TYPE_CHECKING:
    from shapegoogle_core.worker.scene import SceneShape

__all__ = ["SceneReading"]

# Blender's z.
UP_AXIS = 2


class SceneReading:
    """Reads the open scene in slices.

    Between two slices it keeps numbers instead of objects, which may be gone when it is their turn.

    Parameters
    ----------
    context : bpy.types.Context
    output : file object
        For the arrays; a file that can be opened by its name.

    Attributes
    ----------
    items : dict of int to Item
        Objects by their session numbers, as far as they are noted.
    left_out : Counter of str
        How many objects of each kind are no shapes.
    failed : list of (str, str)
        Names of objects that have no mesh, with the reasons.
    expected : int
        Number of shapes that `shapes` has not given yet, once all is read.
    """

    def __init__(self, context: Any, output: BinaryIO) -> None:
        self.items: dict[int, Item] = {}
        self.left_out: Counter[str] = Counter()
        self.failed: list[tuple[str, str]] = []
        self.expected = 0
        self._output = output
        self._writer = MeshWriter(output)
        self._catalogs = catalogs_for(Path(open_source()))
        # What is not evaluated has neither its modifiers nor, perhaps, its place.
        shown, hidden = split_evaluated(list(context.scene.objects), context)
        self.left_out["hidden object"] += sum(item.type in SHAPE_TYPES for item in hidden)
        self._shown = {item.session_uid: None for item in shown}
        self._end = 0.0
        self._here: dict[str, dict[int, Any]] = {}
        self._depsgraph: Any = None
        self._steps = self._read()
        self._entries: list[Entry] = []

    def read(self, seconds: float) -> bool:
        """Go on reading.

        Parameters
        ----------
        seconds : float
            How long, about.

        Returns
        -------
        complete : bool
            Whether all is read.
        """
        self._end, self._here, self._depsgraph = time.monotonic() + seconds, {}, None
        # There is no time at all if the first step, such as to evaluate an object, took it.
        return not any(not self._has_time() for _ in self._steps)

    def shapes(self) -> Generator[SceneShape | None]:
        """Yield the shapes of the scene, and None wherever there may be a pause."""
        from shapegoogle_core.indexing.reading.answer import MeshPlace
        from shapegoogle_core.worker.scene import SceneShape

        self._output.flush()
        entries = [entry for entry in self._entries if entry.placements]
        self.expected = len(entries)
        writer, source = self._writer, open_source()
        for entry in entries:
            record = yield from entry.steps_to_json()
            numbers = {part["mesh"]: None for part in record["parts"]}
            places = tuple(
                MeshPlace(writer.starts[mesh], writer.vertices[mesh], writer.faces[mesh]) for mesh in numbers
            )
            positions = {mesh: position for position, mesh in enumerate(numbers)}
            for part in record["parts"]:
                part["mesh"] = positions[part["mesh"]]
            self.expected -= 1
            yield SceneShape(
                record,
                places,
                Path(self._output.name),
                Path(source),
                up_axis=UP_AXIS,
                alone=len(entries) == 1,
                is_unsaved=is_unsaved(source),
            )

    def _has_time(self) -> bool:
        return time.monotonic() < self._end

    def _object(self, uid: int) -> Any:
        """Return an object; None if it was deleted meanwhile."""
        return self._find("objects", uid)

    def _find(self, kind: str, uid: int) -> Any:
        if kind not in self._here:
            self._here[kind] = {block.session_uid: block for block in getattr(bpy.data, kind)}
        return self._here[kind].get(uid)

    def _evaluated(self) -> Any:
        """Return the depsgraph of the window, the same during a slice."""
        if self._depsgraph is None:
            self._depsgraph = bpy.context.evaluated_depsgraph_get()
        return self._depsgraph

    def _read(self) -> Iterator[None]:
        """Read everything in short steps."""
        for uid in [item.session_uid for item in bpy.data.objects]:
            item = self._object(uid)
            if item is not None:
                self.items[uid] = item_of(item, self._catalogs)
            yield
        listed = [self.items[uid] for uid in self._shown if uid in self.items]
        chosen = [item.uid for item in listed if item.has_mesh]
        carriers = [item for item in listed if item.carries]
        self.left_out.update(item.kind for item in listed if not item.has_mesh and not item.carries)
        groups = yield from self._groups()
        collector = InstanceCollector(SHAPE_TYPES, self._writer.write_part, lambda _item: True)
        while not collector.collect(self._evaluated(), self._has_time):
            yield
        self.left_out["further instance"] += collector.further
        # Without objects that were made meanwhile.
        instances = {uid: [one for one in own if one.uid in self.items] for uid, own in collector.of.items()}
        wholes = yield from self._wholes(groups)
        instanced = (*instances.values(), *wholes.values())
        leaves = list(dict.fromkeys(one.uid for own in instanced for one in own if one.mesh is None))
        # Objects that are only instanced are shapes, too, unless they are in another file.
        only_instanced = [uid for uid in leaves if uid not in self._shown and self.items[uid].is_local]
        read = list(dict.fromkeys([*chosen, *leaves]))
        # Twice each that may be shown more than once.
        some = [self._object(uid) for uid in (*read, *leaves)]
        meshes: SharedMeshes[Entry] = SharedMeshes([item for item in some if item is not None])
        del some
        states: dict[int, State] = {}
        known: dict[tuple[int, bytes], int] = {}
        for uid in read:
            state = self._state(uid, meshes, known)
            if state is not None:
                states[uid] = state
            elif uid in chosen and uid not in instances and (item := self._object(uid)) is not None:
                self.left_out[what_is_empty(item, self.items[uid].kind)] += 1
            yield
        assembly = Assembly(
            self.items.values(), groups, meshes, self._writer.faces, chosen, [*chosen, *only_instanced]
        )
        yield from assembly.add_all(carriers, instances, wholes, states)
        self.left_out.update(assembly.left_out)
        self._entries = assembly.entries

    def _groups(self) -> Generator[None, None, list[Group]]:
        """Note all collections."""
        groups = []
        for uid in [collection.session_uid for collection in bpy.data.collections]:
            collection = self._find("collections", uid)
            if collection is not None:
                groups.append(group_of(collection, self._catalogs))
            yield
        return groups

    def _wholes(self, groups: list[Group]) -> Generator[None, None, dict[int, list[Instance]]]:
        """List what is in the collections that are assets."""
        wholes: dict[int, list[Instance]] = {}
        for group in groups:
            if not group.is_asset:
                continue
            members = [self._object(uid) for uid in group.members & self._shown.keys()]
            own = [
                Instance(item.session_uid, None, item.matrix_world.copy(), group.offset, ())
                for item in sorted((one for one in members if one is not None), key=lambda one: str(one.name))
                if item.session_uid in self.items
            ]
            if own:
                wholes[group.uid] = own
            yield
        return wholes

    def _state(
        self, uid: int, meshes: SharedMeshes[Entry], known: dict[tuple[int, bytes], int]
    ) -> State | None:
        """Write the mesh of an object."""
        item = self._object(uid)
        if item is None:
            return None
        try:
            return evaluated_state(item, self._evaluated(), meshes, self._writer, known)
        except RuntimeError as error:
            if self.items[uid].kind != "metaball":
                text = tr("{name!r} has no mesh once evaluated ({reason}); check its modifiers")
                self.failed.append((item.name, text.format(name=item.name, reason=error)))
        return None
