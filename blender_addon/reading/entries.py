# SPDX-License-Identifier: GPL-3.0-or-later
"""From objects and their instances to shapes: which of them are one, and which are wholes of several meshes.

It imports nothing but Blender's vectors and its neighbours, since `reader` runs in a Blender without this
add-on.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from mathutils import Matrix

from .instancers import Instance
from .records import Group, Item, State
from .sharing import SharedMeshes

__all__ = ["MOST_FACES", "MOST_STRETCHES", "Assembly", "Entry"]

MOST_FACES = 2_000_000
"""Faces that a whole may have; the meshes in it are shapes of their own."""

MOST_STRETCHES = 16
"""Shapes that one object makes of a mesh by stretching its instances; grass may have no two blades alike."""

# Decimals of matrices within a scatter that count as equal.
_DECIMALS = 4


@dataclass
class Entry:
    """A shape on its way into the answer; see `shapegoogle_core.indexing.reading.external_reader`."""

    name: str
    kind: str
    parts: list[tuple[int, Any]]
    names: list[str] = field(default_factory=list)
    tags: list[str] = field(default_factory=list)
    catalog: str = ""
    frame: int | None = None
    placements: list[tuple[str, Any]] = field(default_factory=list)
    color: tuple[float, float, float] | None = None

    def take_asset(self, asset: Item | Group) -> None:
        """Add the tags and the catalog of an asset that is this shape."""
        self.tags += [tag for tag in asset.tags if tag not in self.tags]
        self.catalog = self.catalog or asset.catalog

    def to_json(self) -> dict[str, Any]:
        """Convert to an object of the answer."""
        return _result_of(self.steps_to_json())

    def steps_to_json(self) -> Generator[None, None, dict[str, Any]]:
        """Convert to an object of the answer in short steps; the generator returns it."""
        parts, placements = [], []
        for mesh, matrix in self.parts:
            parts.append({"mesh": mesh, "matrix": _numbers(matrix)})
            yield
        for name, matrix in self.placements:
            placements.append({"object": name, "matrix": _numbers(matrix)})
            yield
        color = {} if self.color is None else {"color": self.color}
        return {
            **color,
            "name": self.name,
            "type": self.kind,
            "names": self.names,
            "tags": self.tags,
            "catalog": self.catalog,
            "frame": self.frame,
            "parts": parts,
            "placements": placements,
        }


class Assembly:
    """Makes entries of objects and instances.

    Parameters
    ----------
    items : iterable of Item
        All objects of the file, and what they instance.
    groups : iterable of Group
        All collections.
    meshes : SharedMeshes
        That has read the objects.
    faces : sequence of int
        Number of faces of each mesh; it may still grow.
    shown : collection of int
        Numbers of the objects that are seen in a scene, not only as instances.
    chosen : collection of int
        Numbers of the objects that are shapes.

    Attributes
    ----------
    entries : list of Entry
    left_out : Counter
        How many objects of each kind are no shapes.
    """

    def __init__(
        self,
        items: Iterable[Item],
        groups: Iterable[Group],
        meshes: SharedMeshes[Entry],
        faces: Sequence[int],
        shown: Collection[int],
        chosen: Collection[int],
    ) -> None:
        self.entries: list[Entry] = []
        self.left_out: Counter[str] = Counter()
        self._items = {item.uid: item for item in items}
        listed = list(groups)
        # The first of those with the same members.
        self._by_members = {group.members: group for group in reversed(listed)}
        self._assets = [group for group in listed if group.is_asset]
        self._meshes = meshes
        self._faces = faces
        self._shown = frozenset(shown)
        self._chosen = frozenset(chosen)
        self._poses: defaultdict[int, list[Entry]] = defaultdict(list)
        # Objects that are an asset collection on their own, and those that are seen as instances.
        self._absorbed: set[int] = set()

    def add_all(
        self,
        carriers: Sequence[Item],
        instances: Mapping[int, Sequence[Instance]],
        wholes: Mapping[int, Sequence[Instance]],
        states: Mapping[int, State],
    ) -> Iterator[None]:
        """Add everything at the first frame, in short steps.

        Parameters
        ----------
        carriers : sequence of Item
            The chosen objects that may instance others.
        instances : mapping of int to sequence of Instance
            By the number of the carrier.
        wholes : mapping of int to sequence of Instance
            What is in collections that are shapes, by their numbers.
        states : mapping of int to State
            Of all objects that could be read, by number.

        Yields
        ------
        None
            After each step, of which a scatter of thousands has thousands.
        """
        instanced = {one.uid for own in instances.values() for one in own if one.mesh is None}
        self._hidden = instanced - self._shown
        used = {item.collection for item in carriers}
        for group in self._assets:
            if group.uid in wholes:
                yield from self._add_collection(group, wholes[group.uid], states, is_used=group.uid in used)
        yield from self.add_objects(states, None)
        for carrier in carriers:
            yield from self._add_instances(carrier, instances.get(carrier.uid, ()), states)

    def add_objects(
        self, states: Mapping[int, State], frame: int | None, first: int | None = None
    ) -> Iterator[None]:
        """Add the chosen objects in short steps; in a pose that it had before, an object gives nothing.

        Parameters
        ----------
        states : mapping of int to State
        frame : int or None
            None if there is only one.
        first : int, optional
            The first frame, at which they were added before.

        Yields
        ------
        None
        """
        for uid in states:
            yield
            if uid not in self._chosen or uid in self._hidden or uid in self._absorbed:
                continue
            item, state, poses = self._items[uid], states[uid], self._poses[uid]
            entry = self._find(item, state.matrix, state.content)
            if entry is not None and entry in poses:
                continue
            if entry is None:
                entry = self._new_of(item, state)
                self._put(item, state.matrix, state.content, entry)
            entry.placements.append((item.name, state.matrix))
            entry.take_asset(item)
            poses.append(entry)
            if len(poses) > 1:
                entry.frame = frame
                poses[0].frame = first if poses[0].frame is None else poses[0].frame

    def _find(self, item: Item, matrix: Any, content: bytes) -> Entry | None:
        return self._meshes.find_by((item.data, content), matrix) if content else None

    def _put(self, item: Item, matrix: Any, content: bytes, entry: Entry) -> None:
        if content:
            self._meshes.put_by((item.data, content), matrix, entry)

    def _new(self, entry: Entry) -> Entry:
        self.entries.append(entry)
        return entry

    def _new_of(self, item: Item, state: State) -> Entry:
        """Make the entry of an object's mesh."""
        entry = self._new(Entry(item.name, item.kind, [(state.mesh, Matrix())]))
        inside = [group.name for group in self._assets if item.uid in group.members]
        entry.color = item.color
        entry.names = [item.data_name, *(f"{name} ({item.name})" for name in inside)]
        entry.take_asset(item)
        return entry

    def _add_collection(
        self, group: Group, own: Sequence[Instance], states: Mapping[int, State], *, is_used: bool
    ) -> Iterator[None]:
        """Add a collection that is an asset."""
        base = group.offset
        parts = yield from self._parts(own, base, states)
        if not parts:
            self.left_out["empty collection"] += 1
            return
        if len(parts) == 1:
            # The only object of the collection is no shape besides it.
            one = next(one for one in own if one.mesh is not None or one.uid in states)
            entry, base = self._entry_of(one, states), one.matrix
            self._absorbed.add(one.uid)
        else:
            whole = self._whole(("collection", group.uid), parts, base)
            if whole is None:
                return
            entry = whole
        entry.name, entry.kind, entry.names = group.name, "collection", []
        if not is_used or group.members & self._shown:
            entry.placements.append((group.name, base))
        entry.take_asset(group)

    def _add_instances(
        self, carrier: Item, own: Sequence[Instance], states: Mapping[int, State]
    ) -> Iterator[None]:
        """Add what an object instances, and the whole that it shows."""
        own = [one for one in own if one.mesh is not None or one.uid in states]
        if not own:
            if not carrier.has_mesh:
                self.left_out["empty"] += 1
            return
        state = states.get(carrier.uid)
        base = own[0].base if state is None else state.matrix
        parts = yield from self._parts(own, base, states)
        if state is not None:
            parts.append((state.mesh, Matrix()))
        if len(parts) == 1:
            entry = self._entry_of(own[0], states)
            # An object that shows nothing else is what an artist selects and appends.
            entry.placements.append((carrier.name, own[0].matrix))
            entry.names.append(carrier.name)
            entry.take_asset(carrier)
            return
        made: Counter[tuple[int, int | None]] = Counter()
        for one in own:
            yield
            # What is linked is a shape of its own file.
            if self._items[one.uid].is_local and (one.mesh is not None or one.uid in self._chosen):
                if self._known_entry(one, states) is None:
                    if made[one.uid, one.mesh] == MOST_STRETCHES:
                        self.left_out["further instance"] += 1
                        continue
                    made[one.uid, one.mesh] += 1
                entry = self._entry_of(one, states)
                entry.placements.append((entry.name, one.matrix))
        if carrier.collection:
            key: tuple[Any, ...] = ("collection", carrier.collection)
        else:
            yield from self._add_groups(carrier, own, states)
            rounded = []
            for mesh, matrix in parts:
                rounded.append((mesh, *[round(number, _DECIMALS) for number in _numbers(matrix)]))
                yield
            key = ("scatter", tuple(sorted(rounded)))
        whole = self._whole(key, parts, base)
        if whole is None:
            return
        if not whole.name:
            whole.name, whole.kind = carrier.name, "instance" if carrier.collection else "scatter"
            whole.names = [carrier.collection_name] if carrier.collection else []
        whole.placements.append((carrier.name, base))
        whole.take_asset(carrier)

    def _known_entry(self, one: Instance, states: Mapping[int, State]) -> Entry | None:
        """Return the entry of the mesh that is instanced, if there is one."""
        if one.mesh is not None:
            return self._meshes.find_by(("mesh", one.mesh), one.matrix)
        return self._find(self._items[one.uid], one.matrix, states[one.uid].content)

    def _entry_of(self, one: Instance, states: Mapping[int, State]) -> Entry:
        """Return the entry of the mesh that is instanced, a new one if there is none."""
        entry = self._known_entry(one, states)
        if entry is None:
            item = self._items[one.uid]
            if one.mesh is not None:
                entry = self._new(Entry(item.name, "object", [(one.mesh, Matrix())]))
                self._meshes.put_by(("mesh", one.mesh), one.matrix, entry)
            else:
                entry = self._new_of(item, states[one.uid])
                self._put(item, one.matrix, states[one.uid].content, entry)
        return entry

    def _add_groups(
        self, carrier: Item, own: Sequence[Instance], states: Mapping[int, State]
    ) -> Iterator[None]:
        """Count what is instanced as one, collections of several objects, as uses of these."""
        together: defaultdict[tuple[int, ...], list[Instance]] = defaultdict(list)
        for one in own:
            if one.mesh is None:
                together[one.group].append(one)
        for some in together.values():
            yield
            members = frozenset(one.uid for one in some)
            group = self._by_members.get(members)
            if group is None or not group.is_local or not 1 < len(members) == len(some):
                continue
            first = states[some[0].uid].matrix
            base = some[0].matrix @ first.inverted_safe() @ group.offset
            parts = yield from self._parts(some, base, states)
            entry = self._whole(("collection", group.uid), parts, base)
            if entry is not None:
                if not entry.name:
                    entry.name, entry.kind = group.name, "collection"
                entry.placements.append((carrier.name, base))

    def _parts(
        self, own: Iterable[Instance], base: Any, states: Mapping[int, State]
    ) -> Generator[None, None, list[tuple[int, Any]]]:
        """List the meshes of a whole, each with its matrix in the space of the whole."""
        back = base.inverted_safe()  # of a flat one approximately
        parts = []
        for one in own:
            if one.mesh is not None:
                parts.append((one.mesh, back @ one.matrix))
            elif one.uid in states:
                parts.append((states[one.uid].mesh, back @ one.matrix))
            yield
        return parts

    def _whole(self, key: tuple[Any, ...], parts: list[tuple[int, Any]], base: Any) -> Entry | None:
        """Return the entry of a whole, a new one without a name if there is none; None if it is too large."""
        if sum(self._faces[mesh] for mesh, _ in parts) > MOST_FACES:
            self.left_out["oversized whole"] += 1
            return None
        entry = self._meshes.find_by(key, base)
        if entry is None:
            entry = self._new(Entry("", "", parts))
            self._meshes.put_by(key, base, entry)
        return entry


def _numbers(matrix: Any) -> list[float]:
    first, second, third, fourth = matrix
    return [*first, *second, *third, *fourth]


def _result_of(steps: Generator[None, None, dict[str, Any]]) -> dict[str, Any]:
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return dict(end.value)
