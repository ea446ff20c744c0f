# SPDX-License-Identifier: MIT
"""Reading files with another Blender, which reads one after the other as it does when folders are indexed."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from shapegoogle_core.indexing import FileShapes, ShapeReader


@pytest.fixture(scope="module")
def read(addon: ModuleType) -> Iterator[Callable[..., FileShapes]]:
    """Read the shapes of a file; the options are those of the reader."""
    reader = importlib.import_module(f"{addon.__name__}.connections").blend_reader()
    opened: dict[tuple[tuple[str, str], ...], ShapeReader] = {}
    with ExitStack() as stack:

        def read_file(path: Path, **options: str) -> FileShapes:
            given = tuple(options.items())
            if given not in opened:
                opened[given] = stack.enter_context(ShapeReader(replace(reader, options=given)))
            return opened[given].read(path)

        yield read_file
