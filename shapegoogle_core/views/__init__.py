# SPDX-License-Identifier: MIT
"""Appearance from outside: pictures of a shape from twelve directions, described by whitened gradients."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
