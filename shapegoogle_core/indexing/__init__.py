# SPDX-License-Identifier: MIT
"""From folders of files to a library.

`files` finds files and notices changes, `reading` turns a file into shapes (`external_reader` asks another
program), `describing` is the work of a process on one file, `file_pool` spreads it over processes, and
`index` is the whole run; `settings` has its limits.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shapegoogle_core.indexing.describing import describe_shape as describe_shape
    from shapegoogle_core.indexing.external_reader import ANSWER as ANSWER
    from shapegoogle_core.indexing.external_reader import ExternalReader as ExternalReader
    from shapegoogle_core.indexing.external_reader import ReaderError as ReaderError
    from shapegoogle_core.indexing.external_reader import ReaderOption as ReaderOption
    from shapegoogle_core.indexing.files import find_meshes as find_meshes
    from shapegoogle_core.indexing.index import FileOutcome as FileOutcome
    from shapegoogle_core.indexing.index import IndexReport as IndexReport
    from shapegoogle_core.indexing.index import index_files as index_files
    from shapegoogle_core.indexing.reading import FileShapes as FileShapes
    from shapegoogle_core.indexing.reading import ShapeReader as ShapeReader
    from shapegoogle_core.indexing.reading import readable_suffixes as readable_suffixes
    from shapegoogle_core.indexing.settings import IndexSettings as IndexSettings

# Imported when first used: the command line shows the default settings without importing numpy.
_MODULE_OF = {
    "ANSWER": "external_reader",
    "ExternalReader": "external_reader",
    "FileOutcome": "index",
    "FileShapes": "reading",
    "IndexReport": "index",
    "IndexSettings": "settings",
    "ReaderError": "external_reader",
    "ReaderOption": "external_reader",
    "ShapeReader": "reading",
    "describe_shape": "describing",
    "find_meshes": "files",
    "index_files": "index",
    "readable_suffixes": "reading",
}

__all__ = sorted(_MODULE_OF)

if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        """Import a public name when it is first used (PEP 562)."""
        if name not in _MODULE_OF:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
