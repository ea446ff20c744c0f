# SPDX-License-Identifier: MIT
"""Labelled sets for "more of the same kind", and the scores of each part of the search on them."""
