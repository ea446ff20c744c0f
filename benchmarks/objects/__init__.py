# SPDX-License-Identifier: MIT
"""Procedural things that people make, in kinds: furniture, vessels, tools, vehicles, buildings, rocks.

Beside the creatures, which bend, these are shapes to develop on: members of a kind differ in proportions and
in the number and the form of their parts. Like models from the hands of artists they are built from
overlapping or loose parts with few triangles, and stand upright. `make_soup` makes the same things as polygon
soup, as rigid models from the web are.
"""

from benchmarks.objects.objects import OBJECT_KINDS, make_object
from benchmarks.objects.soup import make_soup

__all__ = ["OBJECT_KINDS", "make_object", "make_soup"]
