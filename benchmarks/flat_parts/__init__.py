# SPDX-License-Identifier: MIT
"""Flat-sided parts, as CAD programs export them, in families of slightly different sizes."""

from benchmarks.flat_parts.families import FAMILIES, FlatPart, make_parts
from benchmarks.flat_parts.pairs import PartPair, make_part_pairs, versions

__all__ = ["FAMILIES", "FlatPart", "PartPair", "make_part_pairs", "make_parts", "versions"]
