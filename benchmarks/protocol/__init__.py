# SPDX-License-Identifier: MIT
"""The protocol of SHREC 2010: collections, queries, metrics, results."""
