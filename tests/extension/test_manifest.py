# SPDX-License-Identifier: MIT
"""The manifest agrees with the project and with what the add-on does; Blender's tool checks its form."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ADDON = ROOT / "blender_addon"
MANIFEST = tomllib.loads((ADDON / "blender_manifest.toml").read_text(encoding="utf-8"))
SOURCES = {
    path.relative_to(ADDON).as_posix(): path.read_text("utf-8") for path in sorted(ADDON.rglob("*.py"))
}


def sources_with(pattern: str) -> list[str]:
    return [name for name, text in SOURCES.items() if re.search(pattern, text)]


def test_what_the_build_adds_is_not_there_yet() -> None:
    assert not {"version", "wheels", "platforms", "build"} & set(MANIFEST)


def test_permissions_are_those_that_are_used() -> None:
    permissions = MANIFEST["permissions"]
    assert ("clipboard" in permissions) == bool(sources_with(r"\.clipboard\b"))
    assert "files" in permissions
    # The network is used only where the user turned it on and Blender is online.
    assert ("network" in permissions) == bool(sources_with(r"\bonline_access\b"))
    assert set(permissions) <= {"files", "clipboard", "network"}, "no camera or microphone"
    assert all(len(reason) <= 64 and not reason.endswith(".") for reason in permissions.values())


def test_the_addon_uses_no_network_and_no_installer() -> None:
    assert (
        sources_with(r"(?m)^\s*(import|from) (urllib|requests|socket|http|ensurepip|pip)\b|[\"']pip[\"']")
        == []
    )


def test_the_addon_leaves_the_path_alone_and_knows_no_name_of_itself() -> None:
    assert sources_with(r"sys\.path\b.*(append|insert|=)|bl_ext\.") == []
    assert sources_with(r"(?m)^\s*(from|import) blender_addon") == []


def test_every_source_names_its_licence() -> None:
    # The add-on, the models, and the network in the views.
    assert MANIFEST["license"] == ["SPDX:GPL-3.0-or-later", "SPDX:CC0-1.0", "SPDX:Apache-2.0"]
    first_line = "# SPDX-License-Identifier: GPL-3.0-or-later\n"
    assert [name for name, text in SOURCES.items() if not text.startswith(first_line)] == []
