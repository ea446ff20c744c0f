# SPDX-License-Identifier: MIT
"""A collection of shapes in one file: store, search, matches."""

from shapegoogle_core.library.duplicates import DuplicateGroup, DuplicateMember
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.records import NewShape, ShapeRecord, SourceRecord

__all__ = ["DuplicateGroup", "DuplicateMember", "Library", "Match", "NewShape", "ShapeRecord", "SourceRecord"]
