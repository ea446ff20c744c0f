# SPDX-License-Identifier: MIT
"""Local descriptors of every vertex, from the spectrum or from the mesh (paper, sections 3.1 and 3.2)."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
