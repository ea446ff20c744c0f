# SPDX-License-Identifier: MIT
"""The status bar says for a while what was done in the background."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from types import ModuleType
from typing import Any

import bpy
import pytest


def test_a_sentence_is_shown_for_a_while_and_the_latest_as_long_as_others(
    addon: ModuleType, session: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    status_bar = importlib.import_module(f"{addon.__name__}.library.status_bar")
    later: list[Callable[[], None]] = []
    monkeypatch.setattr(bpy.app.timers, "register", lambda call, **_options: later.append(call))
    status_bar.tell(bpy.context, "The first")
    status_bar.tell(bpy.context, "The second")
    assert session.told == "The second"
    later[0]()
    assert session.told == "The second"
    later[1]()
    assert session.told == ""


def test_without_a_sidebar_or_gallery_nothing_shows_matches(addon: ModuleType) -> None:
    jobs = importlib.import_module(f"{addon.__name__}.jobs")
    assert not jobs.shows_matches()


def test_the_status_bar_is_drawn_again_when_a_search_begins_or_ends(
    addon: ModuleType, session: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    properties = importlib.import_module(f"{addon.__name__}.search.properties")
    drawn: list[bool] = []
    monkeypatch.setattr(properties, "redraw_status_bar", lambda: drawn.append(session.searching))
    session.searching = True
    session.searching = False
    assert drawn == [True, False]
