# SPDX-License-Identifier: MIT
"""The stages of a search: candidates, re-ranking, verification, evidence."""
