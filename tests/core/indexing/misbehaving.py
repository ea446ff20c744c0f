# SPDX-License-Identifier: MIT
"""Reading functions that hang, crash or eat memory over files of certain names."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from shapegoogle_core.indexing import ShapeReader
from shapegoogle_core.indexing.reading import describing
from shapegoogle_core.indexing.reading.notes import FileNotes
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.rendering import thumbnail


def read(reader: ShapeReader, path: Path) -> Iterator[NewShape[Mesh] | FileNotes | str]:
    """Do what the file's name says; other files are read as ever."""
    match path.stem:
        case "hangs":
            time.sleep(3600)
        case "aborts":
            # A file is read for a moment before a library crashes over it.
            time.sleep(0.3)
            os.abort()
        case "exits":
            time.sleep(0.3)
            os._exit(3)
        case "swells":
            np.ones(2**31)
        case "raises":
            raise LookupError("nobody foresaw this")
        case "prints":
            print("a library talks")
        case "changes":
            path.write_text(path.read_text() + "# changed\n")
        case "vanishes":
            path.unlink()
    return reader.iterate(path)


def read_and_log(reader: ShapeReader, path: Path) -> Iterator[NewShape[Mesh] | FileNotes | str]:
    """Note beside the library which files were really read."""
    with (Path(os.environ["READ_LOG"])).open("a") as log:
        log.write(f"{path.name}\n")
    return reader.iterate(path)


def read_then_hang(reader: ShapeReader, path: Path) -> Iterator[NewShape[Mesh] | FileNotes | str]:
    """Read a file, and make this process hang when it describes a shape named "x2"."""
    draw = thumbnail

    def hang(mesh: Mesh, *options: Any) -> bytes:
        if mesh.name == "x2":
            time.sleep(3600)
        return draw(mesh, *options)

    setattr(describing, "thumbnail", hang)  # noqa: B010 - it is no variable
    return reader.iterate(path)


def read_then_take_two_seconds(reader: ShapeReader, path: Path) -> Iterator[NewShape[Mesh] | FileNotes | str]:
    """Read a file, and make this process take two seconds for each shape that it describes."""
    draw = thumbnail

    def dawdle(mesh: Mesh, *options: Any) -> bytes:
        time.sleep(2)
        return draw(mesh, *options)

    setattr(describing, "thumbnail", dawdle)  # noqa: B010 - it is no variable
    return reader.iterate(path)
