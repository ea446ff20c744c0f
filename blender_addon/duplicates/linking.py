# SPDX-License-Identifier: GPL-3.0-or-later
"""Let objects share one mesh so that nothing moves; objects where that is not certain are refused.

Blender updates a whole view layer at once, which takes as long for one changed object as for hundreds. So
meshes are compared first, then exchanged in portions with one update each, and then checked.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..scene.selection import split_evaluated
from ..translation import marked, tr
from .congruence import LARGE, congruence_steps
from .exchange import Exchange, Kept, exchange_of, is_deformed, moved_reason, points_seen, put_in_place
from .materials import Materials
from .mesh_data import WorldMesh, differing_steps, world_mesh

FloatArray = NDArray[np.float64]

__all__ = ["LinkRun", "Linked", "link_data"]

HIDDEN = marked(
    "it is disabled in viewports or in an excluded collection, so its place is not known; show it first"
)
# Objects are exchanged in about so many portions, so that a run can be cancelled in between.
PORTIONS = 4
# After a change of meshes Blender rebuilds the relations of all objects, however few have changed.
LEAST_PORTION = 250
# Vertices seen of deformed objects, which are compared in one go after the update.
MOST_POINTS = 500_000


@dataclass(frozen=True)
class Linked:
    """Result of linking.

    Attributes
    ----------
    linked : list of str
        Objects that use the first one's mesh now.
    refused : list of (str, str)
        Objects that were left as they are, and why.
    """

    linked: list[str] = field(default_factory=list)
    refused: list[tuple[str, str]] = field(default_factory=list)


def link_data(context: Any, objects: Sequence[Any]) -> Linked:
    """Give objects the mesh of the first one, their matrices corrected so that nothing moves.

    The meshes are compared again: they may have changed since the duplicates were found. Modifiers,
    materials of objects and children stay where they are.

    Parameters
    ----------
    context : bpy.types.Context
    objects : sequence of bpy.types.Object
        The first one is left as it is.

    Returns
    -------
    linked : Linked
    """
    run = LinkRun(context, [objects])
    for _ in run.steps():
        pass
    return run.result


class LinkRun:
    """Linking of many groups, step by step: between two steps the scene is whole, and the run may end.

    Parameters
    ----------
    context : bpy.types.Context
    groups : sequence of sequence of bpy.types.Object
        The first of each group is left as it is; the others get its mesh.

    Attributes
    ----------
    result : Linked
        Objects linked and refused so far.
    total : int
        Objects that may get another mesh.
    compared : int
        Objects whose meshes have been compared so far.
    """

    def __init__(self, context: Any, groups: Sequence[Sequence[Any]]) -> None:
        self.result = Linked()
        self._context = context
        self._stages = _stages(groups)
        self.total = sum(len(group) - 1 for stage in self._stages for group in stage)
        self.compared = 0
        self._materials = Materials()
        # Each is a walk through all objects of the file: once for all, not once for each.
        self._hidden = set(split_evaluated(bpy.data.objects, context)[1])
        self._children: defaultdict[Any, list[Any]] = defaultdict(list)
        for item in bpy.data.objects:
            if item.parent is not None:
                self._children[item.parent].append(item)

    @property
    def done(self) -> int:
        """Number of objects that are linked or refused."""
        return len(self.result.linked) + len(self.result.refused)

    def steps(self) -> Iterator[bool]:
        """Link; the caller may do something else after each step, but not change objects.

        Yields
        ------
        alone : bool
            Whether the next step, or the last one, takes long: it updates the whole scene, or compares
            large meshes.
        """
        for stage in self._stages:
            exchanges: list[Exchange] = []
            for group in stage:
                yield from self._compare(group, exchanges)
            exchanges = self._without_referred(exchanges)
            for exchanges_of_depth in _by_depth(exchanges):
                yield from self._exchange_all(exchanges_of_depth)

    def _exchange_all(self, exchanges: Sequence[Exchange]) -> Iterator[bool]:
        """Exchange the meshes of objects of which none is below another, in portions."""
        size = max(LEAST_PORTION, -(-len(exchanges) // PORTIONS))
        portion: list[Exchange] = []
        seen: dict[Any, FloatArray] = {}
        points = 0
        for exchange in exchanges:
            portion.append(exchange)
            if is_deformed(exchange.item):
                seen[exchange.item] = points_seen(self._context, exchange.item)
                points += len(seen[exchange.item])
                yield False
            if len(portion) == size or points > MOST_POINTS or exchange is exchanges[-1]:
                yield True
                self._exchange(portion, seen)
                yield True
                portion, seen, points = [], {}, 0

    def _refuse(self, item: Any, reason: str) -> None:
        self.result.refused.append((item.name, reason))

    def _compare(self, group: Sequence[Any], exchanges: list[Exchange]) -> Iterator[bool]:
        """Compare the meshes of a group; adds what to exchange."""
        first = group[0]
        others = [item for item in group[1:] if item.data != first.data]
        self.total -= len(group) - 1 - len(others)
        # The matrices of those that Blender does not evaluate are not to be trusted, nor checked afterwards.
        reason = _mesh_reason(first.data) or (tr("it is being edited") if first.mode != "OBJECT" else "")
        reason = tr(HIDDEN) if first in self._hidden else reason
        target = None if reason else world_mesh(first)
        corrections: dict[Any, tuple[FloatArray, bool] | str] = {}
        for item in others:
            self.compared += 1
            if target is None:
                text = tr("of {name!r}: {reason}")
                self._refuse(item, text.format(name=first.name, reason=reason or tr("it has no extent")))
                yield False
                continue
            reason = tr(HIDDEN) if item in self._hidden else _object_reason(item) or _mesh_reason(item.data)
            if not reason:
                data = item.data
                if data not in corrections:
                    if len(target.polygons.vertices) >= LARGE:
                        yield True
                    own = world_mesh(item)
                    if len(target.polygons.vertices) >= LARGE:
                        yield True
                    corrections[data] = yield from _correction(target, own, self._materials)
                correction = corrections[data]
                if isinstance(correction, str):
                    reason = correction
                else:
                    exchange = exchange_of(item, first.data, correction[0])
                    reason = self._moving_reason(item, exchange.stays, correction[1])
                    if not reason:
                        exchanges.append(exchange)
            if reason:
                self._refuse(item, reason)
            yield False

    def _moving_reason(self, item: Any, stays: bool, same_order: bool) -> str:
        """Why an object must not get a mesh with another origin or order of vertices, or an empty text."""
        children = self._children.get(item, [])
        if not same_order:
            if any(child.parent_type.startswith("VERTEX") for child in children):
                return tr("children hang on its vertices, which are in another order")
            if item.modifiers:
                return tr("it has modifiers, and its vertices are in another order")
        if stays:
            return ""
        if item.modifiers:
            return tr("it has modifiers, and its mesh is placed otherwise in its object")
        if is_deformed(item):
            return tr("its parent deforms it, and its mesh is placed otherwise in its object")
        if _is_animated(item) or item.constraints:
            return tr("it is animated or constrained, and its mesh is placed otherwise in its object")
        if item.rigid_body is not None:
            return tr("it is a rigid body, and its mesh is placed otherwise in its object")
        if any(child.library is not None or child.override_library is not None for child in children):
            return tr("it has children from another file")
        if any(child in self._hidden for child in children):
            return tr(
                "it has children that are disabled in viewports or in excluded collections; show them first"
            )
        return ""

    def _without_referred(self, exchanges: Sequence[Exchange]) -> list[Exchange]:
        """Refuse the objects that would get another matrix while others refer to it."""
        moving = [exchange.item for exchange in exchanges if not exchange.stays]
        users = bpy.data.user_map(subset=moving) if moving else {}
        kept = []
        for exchange in exchanges:
            item = exchange.item
            hangers = [
                user.name
                for user in (() if exchange.stays else users[item])
                if isinstance(user, bpy.types.Object) and user.parent != item and user != item
            ]
            if hangers:
                text = tr("{name!r} refers to it, and its mesh is placed otherwise in its object")
                self._refuse(item, text.format(name=hangers[0]))
            else:
                kept.append(exchange)
        return kept

    def _exchange(self, exchanges: Sequence[Exchange], seen: Mapping[Any, FloatArray]) -> None:
        """Exchange the meshes of some objects; what would move is as before.

        `seen` has the vertices of those that may be seen otherwise than their meshes say.
        """
        context = self._context
        kept = [Kept(exchange.item, self._children.get(exchange.item, [])) for exchange in exchanges]
        for exchange, old in zip(exchanges, kept, strict=True):
            exchange.item.data = exchange.data
            if not exchange.stays:
                put_in_place(exchange, old)
        context.view_layer.update()
        failed = False
        for exchange, old in zip(exchanges, kept, strict=True):
            reason = moved_reason(context, exchange, old, seen.get(exchange.item))
            if reason:
                old.put_back()
                failed = True
                self._refuse(exchange.item, reason)
            else:
                self.result.linked.append(exchange.item.name)
        if failed:
            context.view_layer.update()


def _stages(groups: Sequence[Sequence[Any]]) -> list[list[Sequence[Any]]]:
    """Put groups that share an object with an earlier one into a later stage than that."""
    stages: list[list[Sequence[Any]]] = []
    stage_of: dict[Any, int] = {}
    for group in groups:
        stage = max(stage_of.get(item, -1) for item in group) + 1
        stages.extend([] for _ in range(stage + 1 - len(stages)))
        stages[stage].append(group)
        stage_of.update(dict.fromkeys(group, stage))
    return stages


def _by_depth(exchanges: Sequence[Exchange]) -> list[list[Exchange]]:
    """Objects by the number of those above them that are exchanged too: parents come before children."""
    chosen = {exchange.item for exchange in exchanges}
    waves: defaultdict[int, list[Exchange]] = defaultdict(list)
    for exchange in exchanges:
        depth, above = 0, exchange.item.parent
        while above is not None:
            depth += above in chosen
            above = above.parent
        waves[depth].append(exchange)
    return [waves[depth] for depth in sorted(waves)]


def _mesh_reason(data: Any) -> str:
    """Why a mesh must not be exchanged, or an empty text."""
    if data.library is not None or data.override_library is not None:
        return tr("its mesh lies in another file")
    if data.shape_keys is not None:
        return tr("its mesh has shape keys")
    if _is_animated(data):
        return tr("its mesh is animated")
    return ""


def _object_reason(item: Any) -> str:
    """Why an object must not get another mesh, or an empty text."""
    if item.library is not None or item.override_library is not None:
        return tr("it lies in another file")
    if item.mode != "OBJECT":
        return tr("it is being edited")
    if item.vertex_groups and (item.parent_type == "ARMATURE" or item.find_armature() is not None):
        return tr("an armature deforms it by its vertex groups")
    return ""


def _is_animated(block: Any) -> bool:
    animation = block.animation_data
    return animation is not None and bool(
        animation.action or len(animation.drivers) or len(animation.nla_tracks)
    )


def _correction(
    target: WorldMesh, own: WorldMesh | None, materials: Materials
) -> Generator[bool, None, tuple[FloatArray, bool] | str]:
    """Matrix from the target's mesh to an object's own, and whether the vertices are in the same order."""
    found = None if own is None else (yield from congruence_steps(target.polygons, own.polygons))
    if found is None or own is None:
        return tr("its geometry is not the same any more; find duplicates again")
    differences = yield from differing_steps(target, own, found, materials)
    if differences:
        return tr("it differs in: {data}").format(data=", ".join(differences))
    matrix = np.linalg.inv(own.matrix) @ found.matrix @ target.matrix
    return matrix, found.same_order
