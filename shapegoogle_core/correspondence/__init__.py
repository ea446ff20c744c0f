# SPDX-License-Identifier: MIT
"""Correspondence: maps between the points of a shape and those of the same shape re-posed or re-meshed."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
