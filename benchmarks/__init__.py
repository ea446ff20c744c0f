# SPDX-License-Identifier: MIT
"""Measuring the product; not shipped with it."""
