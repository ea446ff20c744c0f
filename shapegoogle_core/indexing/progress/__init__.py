# SPDX-License-Identifier: MIT
"""What an indexing run reports: outcomes, progress, and the remaining time."""
