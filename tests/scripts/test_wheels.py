# SPDX-License-Identifier: MIT
"""Platforms of wheels, by the names that Blender's manifests use."""

from __future__ import annotations

import platform as this

import pytest
from lib import wheels
from lib.bootstrap import SetupError


@pytest.mark.parametrize(
    ("system", "machine", "name"),
    [
        ("Linux", "x86_64", "linux-x64"),
        ("Windows", "AMD64", "windows-x64"),
        ("Darwin", "arm64", "macos-arm64"),
    ],
)
def test_platforms_have_the_names_of_blenders_manifests(
    monkeypatch: pytest.MonkeyPatch, system: str, machine: str, name: str
) -> None:
    monkeypatch.setattr(this, "system", lambda: system)
    monkeypatch.setattr(this, "machine", lambda: machine)
    assert wheels.this_platform() == name


def test_another_platform_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(this, "system", lambda: "Darwin")
    monkeypatch.setattr(this, "machine", lambda: "riscv64")
    with pytest.raises(SetupError, match="macos-riscv64 is none of the extension's platforms"):
        wheels.this_platform()
