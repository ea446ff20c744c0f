# SPDX-License-Identifier: MIT
"""Measures of whole meshes, and what they tell about two of them."""
