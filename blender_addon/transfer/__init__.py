# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry weights, colours and UVs from a match to the selected object."""

from . import operators

__all__ = ["register", "unregister"]

_MODULES = (operators,)


def register() -> None:
    """Register this feature with Blender."""
    for module in _MODULES:
        module.register()


def unregister() -> None:
    """Unregister this feature."""
    for module in reversed(_MODULES):
        module.unregister()
