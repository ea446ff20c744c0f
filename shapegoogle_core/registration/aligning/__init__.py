# SPDX-License-Identifier: MIT
"""Alignment of a query with many candidates at once: motions of all of them, scored from coarse to fine."""
