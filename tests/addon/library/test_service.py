# SPDX-License-Identifier: GPL-3.0-or-later
"""A library on a server, searched from Blender: a real service with the library of the other tests."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest

from shapegoogle_core import LibraryError
from shapegoogle_core.library.storage import address as addresses
from shapegoogle_core.service.tokens import TokenFile
from shapegoogle_core.worker.requests import library_state
from tests.addon.shapes import lumpy
from tests.core.service.running import Running, running_service

pytestmark = pytest.mark.skipif(
    bool(bpy.app.binary_path), reason="the service runs under a Python with its packages, not in a Blender"
)


@pytest.fixture
def address(addon: ModuleType) -> ModuleType:
    return importlib.import_module(f"{addon.__name__}.library.address")


@pytest.fixture
def service(indexed: Path, preferences: Any, session: Any, tmp_path: Path) -> Iterator[Running]:
    """A service that needs a token, chosen as the library; the folder of its root is not known yet."""
    file = TokenFile(tmp_path / "tokens.json")
    secret = file.create("ana", "write")
    library = preferences.library_path()
    with running_service(library, "--token-file", str(tmp_path / "tokens.json")) as running:
        bpy.context.preferences.system.use_online_access = True
        preferences.library = running.address
        preferences.allow_network, preferences.token = True, secret
        yield running
    preferences.token, preferences.allow_network = "", False
    preferences.roots.clear()


def test_a_service_like_a_file(service: Running, indexed: Path, preferences: Any, session: Any) -> None:
    item = lumpy("Query", 1)
    item.scale = 3, 3, 3
    bpy.context.view_layer.update()
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    best = session.matches[0]
    assert (best.name, best.kind, best.source) == ("Pear", "Scaled ×0.333", f"{indexed.name}/pear.blend")
    assert session.answer.startswith("Query: 3 different shapes, the best of 4, ")
    with pytest.raises(
        RuntimeError, match=r"The folder of 'assets/pear\.blend' is not known .* Folders of Roots"
    ):
        bpy.ops.shape_google.append_match()

    # With the folder of the root the match is a file of this computer.
    assert bpy.ops.shape_google.map_root(root=indexed.name, directory=str(indexed)) == {"FINISHED"}
    bpy.ops.shape_google.mark_example(unlike=True)
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert session.matches[0].name != "Pear"
    session.examples.clear()
    session.text = "pear"
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert [match.source for match in session.matches] == [str(indexed / "pear.blend")]
    assert bpy.ops.shape_google.append_match() == {"FINISHED"}
    assert "Pear" in bpy.data.objects
    assert bpy.ops.shape_google.link_match() == {"FINISHED"}

    assert not bpy.ops.shape_google.index_library.poll()
    assert not bpy.ops.shape_google.move_sources.poll()
    bpy.context.window_manager.shape_google_duplicates.scope = "LIBRARY"
    assert bpy.ops.shape_google.find_duplicates() == {"FINISHED"}

    # What goes wrong is one sentence, and the next search works again once it is mended.
    secret, preferences.token = preferences.token, "wrong"
    with pytest.raises(RuntimeError, match="refuses the token; ask whoever runs the service for one"):
        bpy.ops.shape_google.find_similar()
    preferences.token = secret
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    service.process.kill()
    service.process.wait()
    with pytest.raises(RuntimeError, match="nothing answers at 'http://127"):
        bpy.ops.shape_google.find_similar()


def test_nothing_is_sent_before_it_is_allowed(
    service: Running, addon: ModuleType, address: ModuleType, preferences: Any
) -> None:
    jobs = importlib.import_module(f"{addon.__name__}.jobs")
    lumpy("Query", 1)
    preferences.allow_network = False
    for reason in ("Turn on Search on a Server", "Blender is offline"):
        with pytest.raises(RuntimeError, match=reason):
            bpy.ops.shape_google.find_similar()
        assert reason in address.library_missing(bpy.context)
        # Neither does the worker, whoever asks it.
        asked = jobs.worker().submit(library_state, address.library_address(bpy.context))
        with pytest.raises(LibraryError, match=reason):
            asked.result()
        preferences.allow_network = True
        bpy.context.preferences.system.use_online_access = False
    bpy.context.preferences.system.use_online_access = True


def test_the_token_is_not_in_the_preferences(service: Running, preferences: Any) -> None:
    assert preferences.token
    if bpy.app.version < (5, 0):  # later ones keep properties of add-ons where scripts do not see them
        assert "token" not in set(preferences.keys())
    other, preferences.library = preferences.library, "https://other.example"
    assert preferences.token == ""
    preferences.library = other
    assert preferences.token


def test_addresses_are_told_as_the_core_does(addon: ModuleType) -> None:
    server = importlib.import_module(f"{addon.__name__}.server")
    for place in ("https://a", "HTTP://a", "postgresql://a", "Postgres://a", "/a/b.sglib", "C:\\a.sglib", ""):
        assert server.is_server_address(place) == addresses.is_service(place)
        assert server.is_database_address(place) == addresses.is_database(place)
