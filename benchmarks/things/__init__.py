# SPDX-License-Identifier: MIT
"""Everyday things in kinds to measure on: seats, vessels, vehicles, tools, devices, buildings, plants.

`benchmarks.objects` is there to learn and choose on. These are held out: built independently, each kind in
several ways and from parts that vary, with fine and coarse tessellations and as triangles without any order.
"""

from benchmarks.things.thing import THING_KINDS, make_thing

__all__ = ["THING_KINDS", "make_thing"]
