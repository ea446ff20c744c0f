# SPDX-License-Identifier: MIT
"""A library of shapes: storage, search, duplicates."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shapegoogle_core.library.compare import compare as compare
    from shapegoogle_core.library.duplicates.groups import DuplicateGroup as DuplicateGroup
    from shapegoogle_core.library.duplicates.groups import DuplicateMember as DuplicateMember
    from shapegoogle_core.library.evidence import Evidence as Evidence
    from shapegoogle_core.library.filter import Filter as Filter
    from shapegoogle_core.library.library import Library as Library
    from shapegoogle_core.library.match import Match as Match
    from shapegoogle_core.library.search.settings import SearchSettings as SearchSettings
    from shapegoogle_core.library.storage.records import NewShape as NewShape
    from shapegoogle_core.library.storage.records import ShapeRecord as ShapeRecord
    from shapegoogle_core.library.storage.records import SourceRecord as SourceRecord

# Imported when first used: the command line reads the default settings below this package without numpy.
_MODULE_OF = {
    "DuplicateGroup": "duplicates.groups",
    "DuplicateMember": "duplicates.groups",
    "Evidence": "evidence",
    "Filter": "filter",
    "Library": "library",
    "Match": "match",
    "NewShape": "storage.records",
    "SearchSettings": "search.settings",
    "ShapeRecord": "storage.records",
    "SourceRecord": "storage.records",
    "compare": "compare",
}

__all__ = sorted(_MODULE_OF)

if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        """Import a public name when it is first used (PEP 562)."""
        if name not in _MODULE_OF:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
