# SPDX-License-Identifier: MIT
"""A session: what is open stays open, and what was replaced is opened again."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from shapegoogle_core.errors import LibraryError, ModelError
from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.worker.session import Session


@pytest.fixture
def session() -> Iterator[Session]:
    session = Session()
    yield session
    session.close()


def test_a_library_is_opened_once(session: Session, path: Path, model: ShapeModel) -> None:
    Library.open(path, model).close()
    assert session.library(path) is session.library(path)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not replace files that are open")
def test_a_library_in_the_place_of_another(
    session: Session, path: Path, model: ShapeModel, other_model: ShapeModel
) -> None:
    Library.open(path, model).close()
    first = session.library(path)
    # Beside the other, so that it cannot be given the number of its file.
    other = path.with_name("other.sglib")
    Library.open(other, other_model).close()
    os.replace(other, path)  # noqa: PTH105
    second = session.library(path)
    assert second is not first
    assert second.model.identifier == other_model.identifier


def test_a_library_that_is_not_there(session: Session, path: Path) -> None:
    with pytest.raises(LibraryError, match="there is no library"):
        session.library(path)


def test_a_model_is_loaded_again_when_its_file_changes(
    session: Session, tmp_path: Path, model: ShapeModel, make_model: Callable[..., ShapeModel]
) -> None:
    file = tmp_path / "model.npz"
    model.save(file)
    first = session.model(str(file))
    assert session.model(str(file)) is first
    make_model(seed=7).save(file)
    os.utime(file, (1, 1))
    assert session.model(str(file)).identifier != first.identifier
    with pytest.raises(ModelError):
        session.model(str(tmp_path / "none.npz"))


def test_closing(session: Session, path: Path, model: ShapeModel) -> None:
    Library.open(path, model).close()
    library = session.library(path)
    session.close()
    with pytest.raises(LibraryError):
        len(library)
    assert len(session.library(path)) == 0
