# SPDX-License-Identifier: MIT
"""The trained model: its settings, its file, and how it describes a shape."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
