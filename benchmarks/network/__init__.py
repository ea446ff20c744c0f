# SPDX-License-Identifier: MIT
"""The small network in the views, which was trained on photographs: its file, and what it adds."""

from benchmarks.network.graph import lite0_graph, read_weights

__all__ = ["lite0_graph", "read_weights"]
