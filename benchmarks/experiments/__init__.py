# SPDX-License-Identifier: MIT
"""Measurements of single parts of the search, each a subcommand of `python -m benchmarks`."""
