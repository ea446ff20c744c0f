# SPDX-License-Identifier: MIT
"""Linking many objects at once: few updates, the same result in any order, and whole when it is cancelled."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType, SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from tests.addon.duplicates.objects import add, changed, farthest, find, in_world, link, lump, module, motion


@contextmanager
def counted_updates() -> Iterator[list[int]]:
    """Count how often Blender updates the view layer."""
    counts = [0]

    def count(*_arguments: Any) -> None:
        counts[0] += 1

    bpy.app.handlers.depsgraph_update_post.append(count)
    try:
        yield counts
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(count)


def unmoved(before: dict[str, Any]) -> bool:
    return all(
        farthest(points, in_world(bpy.data.objects[name])) <= 1e-4 * np.linalg.norm(np.ptp(points, axis=0))
        for name, points in before.items()
    )


def copies(count: int) -> list[Any]:
    """Copies of two meshes, each a group of its own, half of them with their motion applied."""
    meshes = [lump(seed=1), lump(seed=2)]
    items = []
    for index in range(count):
        data = meshes[index % 2]
        own = changed(data, motion(index)) if index % 4 > 1 else data.copy()
        item = bpy.data.objects.new(f"copy {index:03}", own)
        bpy.context.scene.collection.objects.link(item)
        item.matrix_world = motion(100 + index)
        items.append(item)
    bpy.context.view_layer.update()
    return items


def test_a_hundred_objects_need_a_handful_of_updates(shown: Any) -> None:
    items = copies(104)
    before = {item.name: in_world(item) for item in items}
    find(shown)
    with counted_updates() as counts:
        assert link(shown) == {"FINISHED"}
    assert len({item.data for item in items}) == 2
    assert counts[0] <= 6
    assert unmoved(before)


def test_parents_and_children_are_linked_in_one_run(shown: Any) -> None:
    data = lump()
    first = add("a", data)
    parent = add("z parent", changed(data, motion(1)), motion(2))
    child = add("b child", changed(data, motion(3)), motion(4))
    grandchild = add("c grandchild", changed(data, motion(5)), motion(6))
    for item, above in ((child, parent), (grandchild, child)):
        item.parent = above
        item.matrix_parent_inverse = above.matrix_world.inverted()
    bpy.context.view_layer.update()
    before = {item.name: in_world(item) for item in (first, parent, child, grandchild)}
    find(shown)
    assert link(shown) == {"FINISHED"}
    bpy.context.view_layer.update()
    assert {item.data for item in (first, parent, child, grandchild)} == {first.data}
    assert unmoved(before)


def test_one_that_cannot_be_held_does_not_keep_the_others_from_being_linked(shown: Any) -> None:
    data = lump()
    add("a", data)
    stretched = bpy.data.objects.new("stretched", None)
    bpy.context.scene.collection.objects.link(stretched)
    stretched.matrix_world = Matrix.Diagonal((1, 1, 4, 1))
    skewed = add("b skewed", data.copy())
    skewed.parent = stretched
    bpy.context.view_layer.update()
    skewed.data.transform(skewed.matrix_world.inverted() @ motion(3))
    child = add("c child", changed(data, motion(4)), motion(5))
    child.parent = skewed
    child.matrix_parent_inverse = skewed.matrix_world.inverted()
    other = add("d other", changed(data, motion(6)))
    bpy.context.view_layer.update()
    items = {item.name: item for item in (skewed, child, other)}
    before, own = {name: in_world(item) for name, item in items.items()}, skewed.data
    find(shown)
    assert link(shown) == {"FINISHED"}
    bpy.context.view_layer.update()
    assert skewed.data == own
    assert child.data == other.data == data
    assert unmoved(before)


@pytest.mark.parametrize("steps", [7, 12])
def test_a_cancelled_run_leaves_a_whole_scene(
    addon: ModuleType, shown: Any, monkeypatch: pytest.MonkeyPatch, steps: int
) -> None:
    linking = module(addon, "duplicates.linking")
    monkeypatch.setattr(linking, "LEAST_PORTION", 2)
    items = copies(12)
    before = {item.name: in_world(item) for item in items}
    run = linking.LinkRun(bpy.context, [items[0::2], items[1::2]])
    walk = run.steps()
    # The first ten steps compare; the exchange begins with the eleventh.
    for _ in range(steps):
        next(walk)
    walk.close()
    bpy.context.view_layer.update()
    linked = set(run.result.linked)
    assert (run.compared, run.total) == (min(10, steps), 10)
    assert bool(linked) == (steps > 10)
    assert unmoved(before)
    for index, item in enumerate(items):
        shares = item.data == items[index % 2].data and index > 1
        assert shares == (item.name in linked)


def test_a_linking_cancelled_by_the_user_is_one_step_of_undo(
    addon: ModuleType, shown: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was linked is kept, what is left is said, the group stays, and Link Data goes on with it."""
    monkeypatch.setattr(module(addon, "duplicates.linking"), "LEAST_PORTION", 2)
    operator = module(addon, "duplicates.link_operator").SHAPEGOOGLE_OT_link_duplicates
    items = copies(12)
    before = {item.name: in_world(item) for item in items}
    find(shown)
    for group in shown.groups:
        group.chosen = True
    said: list[tuple[set[str], str]] = []
    pressed = SimpleNamespace(report=lambda kind, text: said.append((kind, text)))
    operator._start(pressed, bpy.context)
    walk = pressed._run.steps()
    for _ in range(12):
        next(walk)
    walk.close()
    assert operator.finish(pressed, bpy.context, cancelled=True) == {"FINISHED"}
    linked = len(pressed._run.result.linked)
    assert 0 < linked < 10
    assert said == [({"INFO"}, shown.status)]
    assert shown.status == (
        f"Cancelled: {linked} linked, 0 left as they are, {10 - linked} not reached; Link Data goes on with "
        "them"
    )
    bpy.context.view_layer.update()
    assert unmoved(before)
    assert any(group.chosen for group in shown.groups)
    assert bpy.ops.shape_google.link_duplicates() == {"FINISHED"}
    assert len({item.data for item in items}) == 2
    assert unmoved(before)


def test_a_group_may_be_led_by_one_that_an_earlier_group_links(addon: ModuleType, shown: Any) -> None:
    data = lump()
    first, second = add("a", data), add("b", data.copy(), motion(1))
    third = add("c", changed(data, motion(2)))
    before = {item.name: in_world(item) for item in (first, second, third)}
    linking = module(addon, "duplicates.linking")
    run = linking.LinkRun(bpy.context, [[first, second], [second, third]])
    for _ in run.steps():
        pass
    assert run.result.linked == ["b", "c"]
    assert third.data == second.data == first.data
    assert unmoved(before)


def test_large_meshes_are_compared_while_the_window_answers(
    addon: ModuleType, shown: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("groups", "linking", "mesh_data", "congruence"):
        monkeypatch.setattr(module(addon, f"duplicates.{name}"), "LARGE", 1)
    data = lump()
    items = [add("a", data), add("b", changed(data, motion(1)))]
    order = np.random.default_rng(2).permutation(len(data.vertices))
    items.append(add("c", changed(data, motion(2), order)))
    before = {item.name: in_world(item) for item in items}
    collecting = module(addon, "duplicates.groups").Collecting(bpy.context, items)
    assert sum(collecting.steps()) > len(items)
    run = module(addon, "duplicates.linking").LinkRun(bpy.context, [items])
    # Besides one before and one after the exchange.
    assert sum(run.steps()) > 2 + len(items)
    assert sorted(run.result.linked) == ["b", "c"]
    assert unmoved(before)
