# SPDX-License-Identifier: MIT
"""Procedural articulated shapes from seeds: many kinds, any number of individuals and poses."""

from benchmarks.creatures.creature import CREATURE_KINDS, Creature, make_creature

__all__ = ["CREATURE_KINDS", "Creature", "make_creature"]
