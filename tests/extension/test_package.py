# SPDX-License-Identifier: MIT
"""What is in the zips."""

from __future__ import annotations

import re
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import build_extension
import pytest

from shapegoogle_core import __version__

PROJECT = tomllib.loads((Path(__file__).resolve().parents[2] / "pyproject.toml").read_text(encoding="utf-8"))


def normalized(name: str) -> str:
    """Name of a package as one spelling: `scikit_learn` and `Scikit-Learn` are the same."""
    start = re.match(r"[\w.-]+?(?=[=<>! ]|$)", name)
    assert start is not None, name
    return re.sub(r"[-_.]+", "-", start.group()).lower()


@pytest.fixture(scope="module", params=["cp311", "cp313"])
def python_tag(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def package(extensions: Any, python_tag: str) -> Iterator[Any]:
    with zipfile.ZipFile(extensions[python_tag]) as file:
        yield file


@pytest.fixture(scope="module")
def manifest(package: Any) -> Any:
    return tomllib.loads(package.read("blender_manifest.toml").decode())


def test_it_is_whole_and_holds_nothing_twice(package: Any) -> None:
    assert package.testzip() is None
    names = package.namelist()
    assert len(names) == len(set(names))


def test_it_holds_all_wheels_it_names_and_no_others(package: Any, manifest: Any) -> None:
    assert sorted(f"./{name}" for name in package.namelist() if name.endswith(".whl")) == manifest["wheels"]


def test_it_is_small_enough(extensions: Any, python_tag: str) -> None:
    assert extensions[python_tag].stat().st_size <= build_extension.LARGEST


def test_every_package_is_there_for_one_python_and_numpy_is_not(manifest: Any, python_tag: str) -> None:
    tags: dict[str, set[str]] = {}
    for wheel in manifest["wheels"]:
        name, _version, python, *_ = Path(wheel).stem.split("-")
        tags.setdefault(normalized(name), set()).add(python)
    pinned = {normalized(pin) for pin in PROJECT["dependency-groups"]["extension"]}
    assert set(tags) == {*pinned, "shapegoogle-core"}
    assert "numpy" not in tags
    assert {name: pythons for name, pythons in tags.items() if pythons not in ({"py3"}, {python_tag})} == {}


def test_the_pins_are_what_the_core_needs(manifest: Any) -> None:
    pinned = {normalized(pin) for pin in PROJECT["dependency-groups"]["extension"]}
    needed = {normalized(requirement) for requirement in PROJECT["project"]["dependencies"]}
    assert needed - pinned == {"numpy"}


def test_the_version_of_the_core_tells_its_builds_apart(manifest: Any) -> None:
    # Blender does not unpack a wheel of a version that it already has.
    (core,) = (name for name in manifest["wheels"] if "shapegoogle_core" in name)
    assert re.search(rf"-{re.escape(__version__)}\+[0-9a-f]{{8}}-", core)


def test_only_what_is_meant_to_be_is_packed(package: Any) -> None:
    suffixes = {Path(name).suffix for name in package.namelist()}
    assert suffixes <= {".py", ".toml", ".whl", ".png", ".svg", ".md", ".html", ""}
    assert [name for name in package.namelist() if not Path(name).suffix] == ["LICENSE"]
    assert "GNU GENERAL PUBLIC LICENSE" in package.read("LICENSE").decode()
    assert "Replace With Match" in package.read("manual/index.html").decode()
    assert not any("__pycache__" in name or "/." in name for name in package.namelist())
