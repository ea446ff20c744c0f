# SPDX-License-Identifier: MIT
"""Painting in the window: large objects are read while it answers, and nothing changes them meanwhile."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from tests.addon.signature.objects import add_blob, own_names


@pytest.fixture
def window() -> Any:
    """A context with a window whose events a test makes; says what the status bar shows."""
    timers: list[object] = []

    def add(*_arguments: Any, **_options: Any) -> object:
        timers.append(object())
        return timers[-1]

    shown: list[str | None] = []
    manager = SimpleNamespace(
        event_timer_add=add, event_timer_remove=timers.remove, modal_handler_add=lambda _operator: True
    )
    return SimpleNamespace(
        window_manager=manager,
        window=None,
        workspace=SimpleNamespace(status_text_set=shown.append),
        scene=bpy.context.scene,
        view_layer=bpy.context.view_layer,
        mode="OBJECT",
        timers=timers,
        shown=shown,
    )


@pytest.fixture
def pressed(modules: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The operator of a mesh that counts as large."""
    monkeypatch.setattr(modules.painter, "LARGE", 1)
    modules.results.state.current().signature.results.clear()
    operator = modules.painter.Painter()
    operator.reports = []
    operator.report = lambda kind, text: operator.reports.append((kind, text))
    return operator


def event(kind: str) -> Any:
    return SimpleNamespace(type=kind, value="PRESS")


def test_a_large_object_is_read_in_slices(window: Any, pressed: Any, settings: Any) -> None:
    item = add_blob()
    settings.kind, settings.color = "HKS", False
    assert pressed.paint_in_background(window, [item]) == {"RUNNING_MODAL"}
    assert window.shown == [f"Computing {item.name} … (Esc: cancel)"]
    # A click into the scene waits until the object has been read.
    assert pressed.modal(window, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    result = {"RUNNING_MODAL"}
    count = 0
    while result != {"FINISHED"}:
        result = pressed.modal(window, event("TIMER"))
        count += 1
        assert count < 10_000
    assert count > 1
    assert own_names(item) == {"sg_hks"}
    assert not window.timers
    assert window.shown[-1] is None


def test_escape_ends_the_reading(window: Any, pressed: Any, settings: Any) -> None:
    item = add_blob()
    settings.kind = "HKS"
    assert pressed.paint_in_background(window, [item]) == {"RUNNING_MODAL"}
    assert pressed.modal(window, event("ESC")) == {"CANCELLED"}
    assert not own_names(item)
    assert not window.timers
    assert pressed.reports == [({"INFO"}, "Painting cancelled")]
