# SPDX-License-Identifier: MIT
"""Requests of a user interface to its worker process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.model import ShapeModel, ShapeSignature
from shapegoogle_core.worker.requests import library_duplicates, model_of

SignatureMaker = Callable[..., ShapeSignature]


def test_a_library_by_its_path(
    path: Path, model: ShapeModel, make_signature: SignatureMaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Library.open(path, model) as library:
        for name in "ab":
            library.add_signature(make_signature(1), name)
    opened: list[Path] = []
    original = Library.open

    def counted(path: Path, *, read_only: bool, search: SearchSettings | None) -> Library:
        opened.append(path)
        return original(path, read_only=read_only, search=search)

    monkeypatch.setattr(Library, "open", counted)
    assert [[member.name for member in group.members] for group in library_duplicates(path)] == [["a", "b"]]
    assert [[member.name for member in group.members] for group in library_duplicates(path)] == [["a", "b"]]
    assert len(opened) == 1


def test_the_model_by_its_place(path: Path, model: ShapeModel, tmp_path: Path) -> None:
    Library.open(path, model).close()
    model.save(tmp_path / "model.npz")
    assert model_of(path).identifier == model_of(str(tmp_path / "model.npz")).identifier == model.identifier
