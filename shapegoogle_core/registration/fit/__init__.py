# SPDX-License-Identifier: MIT
"""Fits of points to a surface, from a rough position of one shape on another."""
