# SPDX-License-Identifier: MIT
"""Alignment of surfaces: the motion that brings one onto another, and how much of each lies on the other."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
