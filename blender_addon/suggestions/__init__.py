# SPDX-License-Identifier: GPL-3.0-or-later
"""Suggested tags and catalogs for an object, written after confirmation."""

from . import operators, properties

__all__ = ["register", "unregister"]

_MODULES = (properties, operators)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
