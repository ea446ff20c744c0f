# SPDX-License-Identifier: MIT
"""Traits of shapes, by which shapes of one kind are ordered, and those of stored shapes in memory."""
