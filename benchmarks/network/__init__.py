# SPDX-License-Identifier: MIT
"""A small network that was trained on photographs, as one more description of pictures: what it would add."""

from benchmarks.network.features import NetworkFeatures, whitened
from benchmarks.network.graph import lite0_graph, read_weights

__all__ = ["NetworkFeatures", "lite0_graph", "read_weights", "whitened"]
