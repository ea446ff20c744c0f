# SPDX-License-Identifier: MIT
"""Results are kept as long as the object and the file stay the same."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import bpy
import pytest

from tests.addon.conftest import addon_name
from tests.addon.signature.objects import add_blob, paint


class TestCache:
    def test_moving_and_turning_keeps_the_hash_and_scaling_does_not(self, modules: Any) -> None:
        item = add_blob()
        digest = modules.attributes.geometry_hash(item)
        item.location.x += 100
        item.rotation_euler = (1, 2, 3)
        bpy.context.view_layer.update()
        assert modules.attributes.geometry_hash(item) == digest
        item.scale.y *= -1
        bpy.context.view_layer.update()
        assert modules.attributes.geometry_hash(item) == digest
        for factor in (1.01, 1 + 1e-5):
            item.scale.x *= factor
            bpy.context.view_layer.update()
            assert modules.attributes.geometry_hash(item) != digest
            digest = modules.attributes.geometry_hash(item)

    def test_another_cut_of_the_same_bytes_is_another_hash(self, modules: Any) -> None:
        """The corners of two meshes may be the same numbers in the same order."""
        digests = set()
        for polygons in ([(0, 1, 2, 3), (0, 3, 4, 5)], [(0, 1, 2), (3, 0, 3, 4, 5)]):
            data = bpy.data.meshes.new("Sheet")
            data.from_pydata([(x, y, 0) for x in range(3) for y in range(2)], [], polygons)
            item = bpy.data.objects.new("Sheet", data)
            bpy.context.collection.objects.link(item)
            digests.add(modules.attributes.geometry_hash(item))
        assert len(digests) == 2

    def test_is_bounded(self, modules: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        spectra = modules.results
        importlib.import_module(f"{addon_name()}.state").current().signature.results.clear()
        items = [add_blob(3, f"Blob{number}") for number in range(3)]
        for number, item in enumerate(items):
            item.data.vertices[0].co.x += 0.1 * number
        paint_each = [spectra.key_of(item, modules.choices.Painting(), None) for item in items]
        for index, item in enumerate(items):
            task = spectra.task_of(item, modules.choices.Painting(), None, paint_each[index])
            entry = spectra.remember(task, task.function(*task.arguments))
            monkeypatch.setattr(spectra, "MOST_BYTES", 2 * entry.bytes)
        assert [spectra.known(key) is not None for key in paint_each] == [False, True, True]

    def test_is_dropped_with_the_file(self, modules: Any, tmp_path: Path) -> None:
        item = add_blob()
        paint("HKS")
        key = modules.results.key_of(item, modules.properties.settings_of(bpy.context.scene), None)
        assert modules.results.known(key) is not None
        path = str(tmp_path / "empty.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
        bpy.ops.wm.open_mainfile(filepath=path)
        assert modules.results.known(key) is None
