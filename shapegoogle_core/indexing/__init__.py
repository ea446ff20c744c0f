# SPDX-License-Identifier: MIT
"""From folders of files to a library: which files, their shapes, the worker processes, the batch."""

from shapegoogle_core.indexing.batch import FileOutcome, IndexReport, index_files
from shapegoogle_core.indexing.files import find_meshes
from shapegoogle_core.indexing.readers import (
    ANSWER,
    ExternalReader,
    FileShapes,
    FoundShape,
    ReaderOption,
    end_external_readers,
    read_shapes,
    readable_suffixes,
)
from shapegoogle_core.indexing.workers import default_jobs, describe_file

__all__ = [
    "ANSWER",
    "ExternalReader",
    "FileOutcome",
    "FileShapes",
    "FoundShape",
    "IndexReport",
    "ReaderOption",
    "default_jobs",
    "describe_file",
    "end_external_readers",
    "find_meshes",
    "index_files",
    "read_shapes",
    "readable_suffixes",
]
