# SPDX-License-Identifier: MIT
"""What `benchmark_speed.py` measures: a module for each section, and what they share.

A section has

- ``SIZES`` and ``REPEATS``, for whoever names none;
- ``measure(options)``, which gives a row of figures for each thing that it timed, as a dict for JSON;
- ``draw(rows)``, which makes a figure of them.
"""
