# SPDX-License-Identifier: MIT
"""Triangle meshes and point clouds: the value, its checks, and reading it from files."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
