# SPDX-License-Identifier: MIT
"""The neighbour graph of a library: the nearest shapes of each shape, and a walk that orders matches."""
