# SPDX-License-Identifier: MIT
"""Local heat: what a bent part has in common with its whole."""
