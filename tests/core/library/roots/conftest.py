# SPDX-License-Identifier: MIT
"""Small libraries of files in folders."""

from tests.core.small_libraries import folder, indexed, library, library_file

__all__ = ["folder", "indexed", "library", "library_file"]
