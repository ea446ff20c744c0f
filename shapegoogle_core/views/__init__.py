# SPDX-License-Identifier: MIT
"""Appearance from outside: pictures of a shape, described by their gradients and by a network."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
