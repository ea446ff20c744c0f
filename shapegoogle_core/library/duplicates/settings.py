# SPDX-License-Identifier: MIT
"""Default values of the search for duplicates, readable without importing numpy."""

__all__ = ["EXPLAINED_MEMBERS", "MIN_SIMILARITY"]

EXPLAINED_MEMBERS = 1_000
"""Maximum number of members aligned to the first shape of their group; some tens of milliseconds each."""

MIN_SIMILARITY = 0.95
"""Least similarity of two shapes that are called similar.

``docs/reference/library.md`` gives the rates behind it.
"""
