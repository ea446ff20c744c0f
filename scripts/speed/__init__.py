# SPDX-License-Identifier: MIT
"""What `benchmark_speed.py` measures: a module for each section, and the measuring and reporting they share.

A section is a function that takes `Options` and yields a `Row` for each thing it timed; it is entered in
`benchmark_speed.SECTIONS`.
"""
