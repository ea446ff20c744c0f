# SPDX-License-Identifier: MIT
"""Measurements of time and memory: a module for each section of `python -m benchmarks speed`.

A section has

- ``SIZES`` and ``REPEATS``, its defaults;
- ``measure(options)``, which yields a row of figures for each measurement, as a dict for JSON;
- ``draw(rows)``, which plots them.
"""
