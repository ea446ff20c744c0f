# SPDX-License-Identifier: MIT
"""Small libraries of files in folders, in a file and in a database."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel
from tests.core.small_libraries import folder, indexed, library_file

__all__ = ["folder", "indexed", "library_file"]


@pytest.fixture
def library(place: str, model: ShapeModel) -> Iterator[Library]:
    with Library.open(place, model) as opened:
        yield opened
