# SPDX-License-Identifier: MIT
"""From folders of files to a library: which files, their shapes, the worker processes, the batch."""

from shapegoogle_core.indexing.files import find_meshes
from shapegoogle_core.indexing.index import FileOutcome, IndexReport, index_files
from shapegoogle_core.indexing.readers import (
    ANSWER,
    ExternalReader,
    FileShapes,
    FoundShape,
    ReaderError,
    ReaderOption,
    end_external_readers,
    iterate_shapes,
    read_shapes,
    readable_suffixes,
)
from shapegoogle_core.indexing.tasks import DescribedShape, describe_shape
from shapegoogle_core.indexing.workers import default_jobs

__all__ = [
    "ANSWER",
    "DescribedShape",
    "ExternalReader",
    "FileOutcome",
    "FileShapes",
    "FoundShape",
    "IndexReport",
    "ReaderError",
    "ReaderOption",
    "default_jobs",
    "describe_shape",
    "end_external_readers",
    "find_meshes",
    "index_files",
    "iterate_shapes",
    "read_shapes",
    "readable_suffixes",
]
