# SPDX-License-Identifier: MIT
"""Reading functions that hang, crash or eat memory over files of certain names."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from shapegoogle_core.indexing import ExternalReader, FoundShape, iterate_shapes


def read(path: Path, reader: ExternalReader | None = None) -> Iterator[FoundShape | str]:
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
    return iterate_shapes(path, reader)


def read_and_log(path: Path, reader: ExternalReader | None = None) -> Iterator[FoundShape | str]:
    """Note beside the library which files were really read."""
    with (Path(os.environ["READ_LOG"])).open("a") as log:
        log.write(f"{path.name}\n")
    return iterate_shapes(path, reader)
