# SPDX-License-Identifier: MIT
"""Describing functions that hang, crash or eat memory over files of certain names."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np

from shapegoogle_core.indexing.workers import DescribedFile, describe_file
from shapegoogle_core.model import ShapeModel


def describe(path: Path, model: ShapeModel) -> DescribedFile:
    """Do what the file's name says; other files are described as ever."""
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
    return describe_file(path, model)


def describe_and_log(path: Path, model: ShapeModel) -> DescribedFile:
    """Note beside the library which files were really described."""
    with (Path(os.environ["DESCRIBED_LOG"])).open("a") as log:
        log.write(f"{path.name}\n")
    return describe_file(path, model)
