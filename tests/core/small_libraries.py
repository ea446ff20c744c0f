# SPDX-License-Identifier: MIT
"""Folders of small meshes, and libraries of them: fixtures for indexing and commands."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from shapegoogle_core.indexing import ShapeReader, describe_shape, find_meshes
from shapegoogle_core.indexing.files import examine
from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel


@pytest.fixture(scope="session")
def model_file(model: ShapeModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "tiny.npz"
    model.save(path)
    return path


@pytest.fixture
def folder(tmp_path: Path, make_mesh: Callable[..., Path]) -> Path:
    """Three sound meshes in two folders."""
    make_mesh(tmp_path / "meshes" / "apple.off", seed=1)
    make_mesh(tmp_path / "meshes" / "pear.obj", seed=2)
    make_mesh(tmp_path / "meshes" / "more" / "plum.stl", seed=3)
    return tmp_path / "meshes"


@pytest.fixture
def indexed(library: Library, folder: Path) -> Library:
    """A library that knows `folder`, made without the time that worker processes take to start."""
    for path in find_meshes([folder]):
        state, (found,) = examine(path), ShapeReader().read(path).shapes
        shape = describe_shape(found, library.model)
        library.replace_source(
            path, size=state.size, mtime_ns=state.mtime_ns, sha256=state.sha256, shapes=[shape]
        )
    return library


@pytest.fixture
def library_file(tmp_path: Path) -> Path:
    return tmp_path / "shapes.sglib"


@pytest.fixture
def library(library_file: Path, model: ShapeModel) -> Iterator[Library]:
    with Library.open(library_file, model) as opened:
        yield opened
