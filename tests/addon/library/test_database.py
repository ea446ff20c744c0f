# SPDX-License-Identifier: GPL-3.0-or-later
"""A library in a database, searched from Blender: a real PostgreSQL with the library of the other tests."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest

import shapegoogle_core as sg
from benchmarks.studio.server import PostgresqlServer
from shapegoogle_core import LibraryError
from shapegoogle_core.worker.requests import library_state
from tests.addon.shapes import lumpy
from tests.core.postgresql_server import new_server, postgresql

pytestmark = pytest.mark.skipif(
    bool(bpy.app.binary_path), reason="the server is a package of a Python, not of a Blender"
)

__all__ = ["new_server", "postgresql"]


@pytest.fixture
def database(postgresql: PostgresqlServer, indexed: Path, preferences: Any, session: Any) -> Iterator[str]:
    """The library of the other tests in a database, chosen as the library."""
    url = postgresql.new_url()
    sg.copy_library(preferences.library_path(), url)
    bpy.context.preferences.system.use_online_access = True
    preferences.allow_network = True
    preferences.library = url
    yield url
    preferences.token, preferences.allow_network = "", False


def test_a_database_like_a_file(database: str, indexed: Path, preferences: Any, session: Any) -> None:
    item = lumpy("Query", 1)
    item.scale = 3, 3, 3
    bpy.context.view_layer.update()
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    best = session.matches[0]
    assert (best.name, best.kind, best.source) == ("Pear", "Scaled ×0.333", str(indexed / "pear.blend"))
    assert bpy.ops.shape_google.append_match() == {"FINISHED"}
    assert "Pear" in bpy.data.objects

    # A decision is stored in the database, and the next search respects it.
    assert bpy.ops.shape_google.decide_match(kind="MASTER") == {"FINISHED"}
    with sg.Library.open(database, read_only=True) as library:
        assert [decision.kind for decision in library.decisions()] == ["master"]
    bpy.ops.object.select_all(action="DESELECT")
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    bpy.ops.shape_google.mark_example(unlike=True)
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert session.matches[0].name != "Pear"
    bpy.context.window_manager.shape_google_duplicates.scope = "LIBRARY"
    assert bpy.ops.shape_google.find_duplicates() == {"FINISHED"}
    assert not bpy.ops.shape_google.index_library.poll()
    assert not bpy.ops.shape_google.move_sources.poll()


def test_no_database_is_asked_before_it_is_allowed(
    database: str, addon: ModuleType, preferences: Any
) -> None:
    jobs = importlib.import_module(f"{addon.__name__}.jobs")
    address = importlib.import_module(f"{addon.__name__}.library.address")
    lumpy("Query", 1)
    preferences.allow_network = False
    for reason in ("Turn on Search on a Server", "Blender is offline"):
        with pytest.raises(RuntimeError, match=reason):
            bpy.ops.shape_google.find_similar()
        asked = jobs.worker().submit(library_state, address.library_address(bpy.context))
        with pytest.raises(LibraryError, match=reason):
            asked.result()
        preferences.allow_network = True
        bpy.context.preferences.system.use_online_access = False
    bpy.context.preferences.system.use_online_access = True


def test_the_password_is_not_in_the_preferences(addon: ModuleType, preferences: Any) -> None:
    address = importlib.import_module(f"{addon.__name__}.library.address")
    preferences.library = "postgresql://ana:secret@nowhere.invalid/shapes"
    assert preferences.library == "postgresql://ana@nowhere.invalid/shapes"
    assert preferences.token == "secret"
    given = address.library_address(bpy.context)
    assert (given.password, given.token) == ("secret", "")
    assert "secret" not in repr(given)
    assert bpy.ops.shape_google.connect_service(
        address="postgresql://bob:other@nowhere.invalid/shapes", allow=True
    ) == {"FINISHED"}
    assert (preferences.library, preferences.token) == ("postgresql://bob@nowhere.invalid/shapes", "other")
    for place in (preferences.library, "postgresql://ana@nowhere.invalid/shapes"):
        preferences.library = place
        preferences.token = ""
    preferences.allow_network = False


def test_a_database_that_is_not_there(preferences: Any, tmp_path: Path) -> None:
    lumpy("Query", 1)
    preferences.library = f"postgresql://ana@/shapes?host={tmp_path}"
    preferences.allow_network, bpy.context.preferences.system.use_online_access = True, True
    with pytest.raises(RuntimeError, match="cannot be opened: no server answers there"):
        bpy.ops.shape_google.find_similar()
    preferences.allow_network = False
