# SPDX-License-Identifier: MIT
"""Roots: the named folders that the files of a library lie below; moving and forgetting them."""
