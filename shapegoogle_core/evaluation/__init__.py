# SPDX-License-Identifier: MIT
"""Transformations, procedural shapes, protocol and metrics: how well the search works."""
