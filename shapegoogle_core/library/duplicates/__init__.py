# SPDX-License-Identifier: MIT
"""Groups of duplicates in a library."""
