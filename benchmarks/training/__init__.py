# SPDX-License-Identifier: MIT
"""Training of the shipped models, and the shapes for it."""
