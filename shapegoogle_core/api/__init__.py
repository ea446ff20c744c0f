# SPDX-License-Identifier: MIT
"""Shared by all public functions: checks of their arguments, and names that are imported at first use."""
