# SPDX-License-Identifier: MIT
"""Variants of the method, and baselines to compare it with."""
