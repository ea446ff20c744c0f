# SPDX-License-Identifier: MIT
"""The parts of `Library`, from the bottom up: folders, sources, listing, contents, comparing, and search."""
