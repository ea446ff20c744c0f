# SPDX-License-Identifier: MIT
"""A library of shapes: storage, search, duplicates."""
