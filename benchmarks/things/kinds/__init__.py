# SPDX-License-Identifier: MIT
"""Kinds of objects, one function each, by what they are used for."""
