# SPDX-License-Identifier: MIT
"""Skeletons and poses of each kind of creature."""
