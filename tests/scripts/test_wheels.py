# SPDX-License-Identifier: MIT
"""Platforms of wheels, by the names that Blender's manifests use."""

from __future__ import annotations

import platform as this
import subprocess
from pathlib import Path

import build_extension
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


def test_markers_are_about_the_platform_of_the_zip() -> None:
    asked = [
        "a==1",
        "b==1; sys_platform != 'darwin'",
        "b==2; sys_platform == 'darwin'",
        "c==3; python_version < '3.13'",
    ]
    assert wheels.pins_for("macos-arm64", "3.13", asked) == ["a==1", "b==2"]
    assert wheels.pins_for("windows-x64", "3.11", asked) == ["a==1", "b==1", "c==3"]


@pytest.mark.long
@pytest.mark.parametrize("python", build_extension.pythons())
@pytest.mark.parametrize("target", wheels.TAGS)
def test_every_package_of_the_extension_has_a_wheel_for_every_platform(
    target: str, python: str, tmp_path: Path
) -> None:
    pins = wheels.pins_for(target, python, build_extension.pyproject()["dependency-groups"]["extension"])
    options = ["--no-deps", *wheels.pip_options(target, python), "--dry-run", f"--target={tmp_path}"]
    result = subprocess.run(
        [*build_extension.PIP, "install", *build_extension.PIP_OPTIONS, *options, *pins],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
