# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare a match with the query: side by side, turning together, coloured by their distance."""

from .operators import register, unregister

__all__ = ["register", "unregister"]
