# SPDX-License-Identifier: MIT
"""From folders of mesh files to a library: which files, the worker processes, the batch."""

from shapegoogle_core.indexing.batch import FileOutcome, IndexReport, index_files
from shapegoogle_core.indexing.files import find_meshes

__all__ = ["FileOutcome", "IndexReport", "find_meshes", "index_files"]
